// A small run with its ground truth, and helpers to write files for the readers under test.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "dynemo/core/error.h"
#include "dynemo/evaluation/entity_error.h"
#include "dynemo/evaluation/trajectory.h"

namespace dynemo::test {

class Folder {
 public:
  Folder() {
    static int count = 0;
    path_ = std::filesystem::temp_directory_path() /
            ("dynemo-evaluation-" + std::to_string(::getpid()) + "-" + std::to_string(++count));
    std::filesystem::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name, std::ios::binary) << text;
    return path_ / name;
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// The message of the DataError that `call` throws; empty when it throws none.
template <class Call>
std::string dataError(Call call) {
  try {
    call();
  } catch (const DataError& e) {
    return e.what();
  }
  return "";
}

inline Stamp at(double seconds) {
  return {1'700'000'000'000'000'000 + static_cast<std::int64_t>(std::llround(seconds * 1e9))};
}

/// A curve through space, `count` poses at 10 Hz, every pose turned another way.
inline Trajectory curve(int count) {
  Trajectory trajectory;
  for (int i = 0; i < count; ++i) {
    const double s = 0.1 * i;
    trajectory.push_back(
        {at(s), Pose3::fromYawPitchRoll(3.0 * std::cos(s), 2.0 * std::sin(s),
                                        0.3 * std::sin(2.0 * s), s, 0.1 * s, -0.05 * s)});
  }
  return trajectory;
}

inline EntityEstimate estimate(std::uint64_t node, std::int64_t entity, double seconds,
                               const Pose3& T) {
  EntityEstimate e;
  e.node = {node};
  e.entity = {entity};
  e.stamp = at(seconds);
  e.T_map_entity = e.T_map_entity_first = T;
  return e;
}

/// Object 1 rests at the origin until 10 s and at x = 2 m from then on; object 2 never moves; agent
/// 101 walks along x at 1 m/s.
inline EntityTruths exampleTruths() {
  EntityTruths truths;
  const Pose3 T_first, T_second = Pose3::fromYawPitchRoll(2, 0, 0, 1.0, 0, 0);
  truths[{1}].poses = {
      {at(0), T_first}, {at(9.999999), T_first}, {at(10), T_second}, {at(20), T_second}};
  truths[{2}].poses = {{at(0), Pose3::translation(0, 5, 0)}, {at(20), Pose3::translation(0, 5, 0)}};
  truths[{101}].semantic_class = SemanticClass::kAgent;
  truths[{101}].poses = {{at(0), Pose3()}, {at(20), Pose3::translation(20, 0, 0)}};
  return truths;
}

}  // namespace dynemo::test
