#include "dynemo/evaluation/trajectory.h"

#include <algorithm>
#include <cstdio>
#include <sstream>
#include <stdexcept>

#include "dynemo/core/error.h"
#include "dynemo/core/output_file.h"
#include "text_input.h"

namespace dynemo {
namespace {

constexpr std::size_t kColumns = 8;

std::vector<std::string> words(const std::string& line) {
  std::istringstream in(line);
  std::vector<std::string> list;
  for (std::string word; in >> word;) list.push_back(word);
  return list;
}

StampedPose parsePose(const std::vector<std::string>& columns, const std::string& origin,
                      std::size_t line) {
  if (columns.size() != kColumns) {
    failAt(origin, line,
           std::to_string(columns.size()) + " columns; expected 8: timestamp x y z qx qy qz qw");
  }
  StampedPose pose;
  try {
    pose.stamp = Stamp::parse(columns[0]);
  } catch (const std::invalid_argument& e) {
    failAt(origin, line, e.what());
  }
  double values[7];
  for (std::size_t i = 0; i < 7; ++i) {
    const auto value = finiteNumber(columns[i + 1]);
    if (!value) failAt(origin, line, "'" + columns[i + 1] + "' is not a finite number");
    values[i] = *value;
  }
  const auto T = poseFromColumns(values);
  if (!T) failAt(origin, line, "a quaternion of length zero");
  pose.T = *T;
  return pose;
}

bool earlier(const StampedPose& a, const StampedPose& b) { return a.stamp < b.stamp; }

}  // namespace

Trajectory parseTum(const std::string& text, const std::string& origin) {
  Trajectory trajectory;
  std::istringstream lines(text);
  std::size_t number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    const auto columns = words(line);
    if (columns.empty() || columns.front().starts_with('#')) continue;
    trajectory.push_back(parsePose(columns, origin, number));
  }
  if (trajectory.empty()) throw DataError(origin + ": holds no poses");
  std::stable_sort(trajectory.begin(), trajectory.end(), earlier);
  return trajectory;
}

Trajectory readTum(const std::filesystem::path& file) {
  return parseTum(readTextFile(file), file.string());
}

std::string tumText(const Trajectory& trajectory) {
  std::string text;
  char buffer[400];
  for (const auto& [stamp, T] : trajectory) {
    text += stamp.text();
    const Eigen::Quaterniond q = T.quaternion();
    for (const double value : {T.t.x(), T.t.y(), T.t.z(), q.x(), q.y(), q.z(), q.w()}) {
      std::snprintf(buffer, sizeof(buffer), " %.9f", value);
      text += buffer;
    }
    text += '\n';
  }
  return text;
}

void writeTum(const Trajectory& trajectory, const std::filesystem::path& file) {
  writeFileAtomically(file, tumText(trajectory));
}

std::optional<Pose3> poseAt(const Trajectory& trajectory, Stamp stamp) {
  const auto after =
      std::lower_bound(trajectory.begin(), trajectory.end(), StampedPose{stamp, {}}, earlier);
  if (after == trajectory.end()) return std::nullopt;
  if (after->stamp == stamp) return after->T;
  if (after == trajectory.begin()) return std::nullopt;
  const auto before = after - 1;
  const double fraction =
      secondsBetween(before->stamp, stamp) / secondsBetween(before->stamp, after->stamp);
  return interpolate(before->T, after->T, fraction);
}

}  // namespace dynemo
