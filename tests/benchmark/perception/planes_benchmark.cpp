// Extraction of planes from one scan of a furnished room, by every registered extractor.
#include <benchmark/benchmark.h>

#include <algorithm>

#include "dynemo/perception/plane_extractor.h"
#include "synthetic_world.h"

namespace dynemo {
namespace {

/// Ring by ring, as a list without rows and columns.
Scan ringByRing(int rings, int columns) {
  test::LidarModel lidar;
  lidar.rows = rings;
  lidar.columns = columns;
  lidar.sweep_s = 0.0;
  std::mt19937_64 random(1);
  Scan scan = test::sweep(
      test::furnishedRoom(), lidar, [](double) { return Pose3::translation(-1, -1, 0.8); }, 0.0,
      random);
  std::vector<Eigen::Vector3f> points;
  for (int r = 0; r < rings; ++r)
    for (int c = 0; c < columns; ++c)
      points.push_back(scan.cloud.points[static_cast<std::size_t>(c * rings + r)]);
  scan.cloud.points = std::move(points);
  return scan;
}

void extractPlanes(benchmark::State& state, const std::string& name) {
  const Scan scan = ringByRing(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  const auto extractor = planeExtractors().make(name, PlaneParams());
  std::size_t planes = 0;
  for (auto _ : state) planes = extractor->extract(scan).size();
  state.counters["planes"] = static_cast<double>(planes);
}

const bool kRegistered = [] {
  for (const std::string& name : planeExtractors().names()) {
    benchmark::RegisterBenchmark(("extractPlanes/" + name).c_str(), extractPlanes, name)
        ->ArgNames({"rings", "columns"})
        ->Args({32, 512})
        ->Args({64, 1024})
        ->Unit(benchmark::kMillisecond);
  }
  return true;
}();

}  // namespace
}  // namespace dynemo
