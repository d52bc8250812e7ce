// Trajectories as lists of stamped poses, and their TUM text form.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "dynemo/core/se3.h"
#include "dynemo/core/time.h"

namespace dynemo {

struct StampedPose {
  Stamp stamp;
  Pose3 T;
};

/// Ascending by stamp.
using Trajectory = std::vector<StampedPose>;

/// Reads lines "timestamp x y z qx qy qz qw" [s, m]; blank lines and lines that start with # are
/// skipped, columns are separated by any white space, quaternions are normalised, poses sorted by
/// stamp. Throws DataError, naming `origin` and the line, when a line is malformed, and when there
/// is no pose at all.
Trajectory parseTum(const std::string& text, const std::string& origin);

/// parseTum of a file; throws DataError when it cannot be read.
Trajectory readTum(const std::filesystem::path& file);

/// The text of readTum, nine fractional digits.
std::string tumText(const Trajectory& trajectory);

/// Writes tumText in one step. Throws DataError when the file cannot be written.
void writeTum(const Trajectory& trajectory, const std::filesystem::path& file);

/// Pose at a stamp: the stored one, or interpolated between the neighbours (linear translation,
/// constant-rate rotation). Empty outside the trajectory's span.
std::optional<Pose3> poseAt(const Trajectory& trajectory, Stamp stamp);

}  // namespace dynemo
