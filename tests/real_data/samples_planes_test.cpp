// Planes in single scans of the samples against the true walls.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <iostream>

#include "dynemo/core/noise.h"
#include "dynemo/perception/plane_extractor.h"
#include "sample_dataset.h"

namespace dynemo {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180.0;
/// A wall counts as seen with this many points, and as found by a plane this close to it.
constexpr std::size_t kMinPoints = 500;
constexpr double kMaxAngle_rad = 1.5 * kDegree, kMaxOffset_m = 0.03, kOnWall_m = 0.03;
constexpr int kEveryFrame = 4;
/// A wall seen in parts at a grazing angle may be two planes in one scan; the map joins them.
constexpr double kMaxTwice = 0.01;

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values.empty() ? 0.0 : values[values.size() / 2];
}

struct Result {
  int walls = 0, found = 0, twice = 0, planes = 0, unknown = 0;
  std::vector<double> angle_rad, offset_m, chi2, cpu_ms;
  double recall() const { return static_cast<double>(found) / std::max(1, walls); }
};

Vector3 residual(const PlaneObservation& o, const Plane3& truth_base) {
  Vector3 e;
  e << sphereLog(o.patch_base.normal, truth_base.normal).w,
      truth_base.distance(o.patch_base.center);
  return e;
}

bool isSame(const Vector3& e) {
  return e.head<2>().norm() < kMaxAngle_rad && std::abs(e.z()) < kMaxOffset_m;
}

void compare(const Scan& scan, const Pose3& T_world_base, const test::SampleTruth& truth,
             const std::vector<PlaneObservation>& observations, Result& result) {
  std::vector<Vector3> points;
  for (const auto& p : scan.cloud.points) {
    points.push_back(T_world_base * scan.T_base_lidar * p.cast<double>());
  }
  const Vector3 sensor = T_world_base * scan.T_base_lidar.t;
  std::vector<char> known(observations.size(), 0);
  for (const test::TruePlane& wall : truth.planes()) {
    if (wall.plane_world.distance(sensor) < 0.0) continue;
    const auto seen = std::count_if(points.begin(), points.end(),
                                    [&](const Vector3& p) { return wall.contains(p, kOnWall_m); });
    int matches = 0;
    for (std::size_t i = 0; i < observations.size(); ++i) {
      const Vector3 e = residual(observations[i], T_world_base.inverse() * wall.plane_world);
      const Vector3 center = T_world_base * observations[i].patch_base.center;
      if (!isSame(e) || !wall.contains(center, 0.1)) continue;
      known[i] = 1;
      if (matches++ > 0) continue;
      result.angle_rad.push_back(e.head<2>().norm());
      result.offset_m.push_back(std::abs(e.z()));
      result.chi2.push_back(squaredMahalanobis(e, observations[i].covariance));
    }
    result.twice += matches > 1 ? 1 : 0;
    if (static_cast<std::size_t>(seen) < kMinPoints) continue;
    ++result.walls;
    result.found += matches > 0 ? 1 : 0;
  }
  result.planes += static_cast<int>(observations.size());
  result.unknown += static_cast<int>(std::count(known.begin(), known.end(), 0));
}

Result evaluate(const std::filesystem::path& folder, const std::string& name,
                const std::string& extractor_name) {
  const test::SampleTruth truth(folder, name);
  test::SampleFrames frames(folder, name);
  const auto extractor = planeExtractors().make(extractor_name, PlaneParams());
  Result result;
  int index = 0;
  while (const auto frame = frames.next()) {
    if (!frame->scan || index++ % kEveryFrame != 0) continue;
    const auto T_world_base = truth.T_world_base(frame->scan->stamp);
    if (!T_world_base) continue;
    const std::clock_t start = std::clock();
    const auto observations = extractor->extract(*frame->scan);
    result.cpu_ms.push_back(1e3 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
    compare(*frame->scan, *T_world_base, truth, observations, result);
  }
  std::cout << name << ", " << extractor_name << ": " << result.found << " of " << result.walls
            << " walls with " << kMinPoints << " points found, " << result.twice << " twice, "
            << result.unknown << " of " << result.planes << " planes on no wall; median angle "
            << median(result.angle_rad) / kDegree << " deg, offset "
            << 1e3 * median(result.offset_m) << " mm, chi2(3) " << median(result.chi2) << ", CPU "
            << median(result.cpu_ms) << " ms\n";
  return result;
}

class SamplePlanes : public ::testing::TestWithParam<std::string> {};

TEST_P(SamplePlanes, AreTheTrueWalls) {
  const auto folder = test::samplesFolder();
  if (!folder) GTEST_SKIP() << "set DYNEMO_SAMPLES to the folder with the samples";
  for (const std::string name : {"mini_samo", "mini_mamo"}) {
    const Result result = evaluate(*folder / name, name, GetParam());
    EXPECT_GE(result.recall(), 0.95);
    EXPECT_LE(result.twice, kMaxTwice * result.walls);
    EXPECT_LT(median(result.angle_rad), 0.1 * kDegree);
    EXPECT_LT(median(result.offset_m), 0.002);
    EXPECT_LT(median(result.chi2), 7.8);
  }
}

INSTANTIATE_TEST_SUITE_P(Registry, SamplePlanes, ::testing::ValuesIn(planeExtractors().names()),
                         [](const auto& test) { return test.param; });

}  // namespace
}  // namespace dynemo
