#include "pose_text.h"

#include <array>
#include <cstdio>

namespace dynemo {
namespace {

std::array<double, 7> values(const Pose3& T) {
  const Eigen::Quaterniond q = T.quaternion();
  return {T.t.x(), T.t.y(), T.t.z(), q.x(), q.y(), q.z(), q.w()};
}

std::string formatted(const char* format, double value) {
  char buffer[400];  // the widest finite double needs 310 digits before the point
  const int length = std::snprintf(buffer, sizeof(buffer), format, value);
  return {buffer, static_cast<std::size_t>(length)};
}

std::string joined(const Pose3& T, const char* format, char separator) {
  std::string text;
  for (const double value : values(T)) {
    if (!text.empty()) text += separator;
    text += formatted(format, value);
  }
  return text;
}

}  // namespace

std::string poseText(const Pose3& T, char separator) { return joined(T, "%.9f", separator); }

std::string tumLine(Stamp stamp, const Pose3& T) {
  return stamp.text() + ' ' + poseText(T, ' ') + '\n';
}

std::string exactPoseText(const Pose3& T) { return joined(T, "%.17g", ' '); }

std::string fixedText(double value) { return formatted("%.9f", value); }

std::string exactText(double value) { return formatted("%.17g", value); }

}  // namespace dynemo
