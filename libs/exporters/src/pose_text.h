// Poses as the text formats write them.
#pragma once

#include <string>

#include "dynemo/core/se3.h"
#include "dynemo/core/time.h"

namespace dynemo {

/// "x y z qx qy qz qw" with the given separator and nine fractional digits [m, unit quaternion with
/// w ≥ 0].
std::string poseText(const Pose3& T, char separator);

/// One line of a TUM trajectory, "timestamp x y z qx qy qz qw\n".
std::string tumLine(Stamp stamp, const Pose3& T);

/// "x y z qx qy qz qw" with 17 significant digits: reads back as the same doubles.
std::string exactPoseText(const Pose3& T);

/// Nine fractional digits.
std::string fixedText(double value);

/// 17 significant digits.
std::string exactText(double value);

}  // namespace dynemo
