// The stages of LiDAR odometry on sweeps of 64 × 1024 points of a furnished room.
#include <benchmark/benchmark.h>

#include "dynemo/odometry/deskew.h"
#include "dynemo/odometry/odometry_params.h"
#include "dynemo/odometry/point_times.h"
#include "dynemo/odometry/scan_odometry.h"
#include "synthetic_world.h"

namespace dynemo {
namespace {

constexpr double kRate_hz = 10.0;

const std::vector<Scan>& scans() {
  static const std::vector<Scan> all = [] {
    std::mt19937_64 random(1);
    std::vector<Scan> list;
    for (int i = 0; i < 20; ++i) {
      list.push_back(test::sweep(test::furnishedRoom(), test::LidarModel(), test::handHeldWalk(),
                                 i / kRate_hz, random));
    }
    return list;
  }();
  return all;
}

SurfacePoints surfaceOf(const Scan& scan, WorkerPool& pool) {
  return extractSurface(scan, scan.cloud.time_offset_s, middleOfSweep(scan.cloud), {}, {},
                        SurfaceParams(), pool);
}

VoxelHashMap mapOf(const SurfacePoints& surface) {
  VoxelHashMap map({});
  for (std::size_t i = 0; i < surface.size(); ++i)
    map.insert(surface.points[i], surface.normals[i]);
  return map;
}

void deskewScan(benchmark::State& state) {
  const Scan& scan = scans()[5];
  const SweepMotion motion{{{1, 0, 0}, {0, 0.2, 0.5}}, {}};
  for (auto _ : state) {
    benchmark::DoNotOptimize(deskew(scan.cloud, scan.T_base_lidar, motion, 0.0));
  }
}
BENCHMARK(deskewScan)->Unit(benchmark::kMillisecond);

void preprocessing(benchmark::State& state) {
  WorkerPool pool(static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(surfaceOf(scans()[5], pool));
}
BENCHMARK(preprocessing)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

void registration(benchmark::State& state) {
  WorkerPool pool(static_cast<int>(state.range(0)));
  const VoxelHashMap map = mapOf(surfaceOf(scans()[5], pool));
  const SurfacePoints scan = surfaceOf(scans()[6], pool);
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        registerScan(scan, map, RegistrationPrior(), RegistrationParams(), pool));
  }
}
BENCHMARK(registration)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

void mapInsertion(benchmark::State& state) {
  WorkerPool pool(1);
  const SurfacePoints surface = surfaceOf(scans()[5], pool);
  for (auto _ : state) benchmark::DoNotOptimize(mapOf(surface).cells());
}
BENCHMARK(mapInsertion)->Unit(benchmark::kMillisecond);

/// One scan of a run, all stages; the settling of the first ten sweeps is left out.
void wholeScan(benchmark::State& state) {
  OdometryParams params;
  params.threads = static_cast<int>(state.range(0));
  for (auto _ : state) {
    state.PauseTiming();
    const auto odometry = scanOdometries().make(params.method, params);
    for (std::size_t i = 0; i < 11; ++i) odometry->update(scans()[i], std::nullopt);
    state.ResumeTiming();
    for (std::size_t i = 11; i < scans().size(); ++i) {
      benchmark::DoNotOptimize(odometry->update(scans()[i], std::nullopt));
    }
  }
  state.counters["ms_per_scan"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * 9.0,
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK(wholeScan)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace dynemo
