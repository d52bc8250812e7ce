// Decoding and synchronising, on rawlogs generated in a temporary folder.
//   bench_ingest --benchmark_filter=Frames
#include <benchmark/benchmark.h>

#include "dynemo/ingest/decoders.h"
#include "dynemo/ingest/rawlog_source.h"
#include "dynemo/ingest/synchronizer.h"
#include "generated_rawlog.h"

namespace dynemo {
namespace {

using namespace test;  // NOLINT

/// Ten seconds with a scan and an image every 0.1 s; the argument is the number of points of a
/// scan.
void BM_FramesFromRawlog(benchmark::State& state, bool compressed) {
  const TemporaryFolder folder;
  const fs::path log = folder / "log.rawlog";
  writeLog(log, {.duration_s = 10.0,
                 .points = static_cast<std::size_t>(state.range(0)),
                 .compressed = compressed});
  std::int64_t frames = 0;
  for (auto _ : state) {
    const auto source = makeRawlogSource({}, log);
    while (const auto frame = source->next()) ++frames;
  }
  state.SetItemsProcessed(frames);
}
BENCHMARK_CAPTURE(BM_FramesFromRawlog, plain, false)
    ->Arg(16384)
    ->Arg(65536)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_FramesFromRawlog, compressed, true)->Arg(16384)->Unit(benchmark::kMillisecond);

void BM_DecodePointCloud(benchmark::State& state) {
  auto o = cloudObservation(0, static_cast<std::size_t>(state.range(0)));
  IngestParams params;
  if (state.range(1) != 0) params.lidar.sweep_rate_hz = 10;
  const std::map<std::string, Pose3> extrinsics;
  const ExternalFiles files;
  WarningCounter warnings;
  const DecodeContext context{params, extrinsics, files, warnings};
  for (auto _ : state) benchmark::DoNotOptimize(decodePointCloud(o, context));
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(BM_DecodePointCloud)
    ->ArgNames({"points", "timed"})
    ->Args({16384, 0})
    ->Args({65536, 0})
    ->Args({65536, 1})
    ->Unit(benchmark::kMicrosecond);

void BM_DecodeImage(benchmark::State& state) {
  auto o = imageObservation(0, "camera", static_cast<int>(state.range(0)));
  IngestParams params;
  const std::map<std::string, Pose3> extrinsics;
  const ExternalFiles files;
  WarningCounter warnings;
  const DecodeContext context{params, extrinsics, files, warnings};
  for (auto _ : state) benchmark::DoNotOptimize(decodeImage(o, context));
}
BENCHMARK(BM_DecodeImage)->ArgName("channels")->Arg(1)->Arg(3);

/// Per scan: two cameras and five samples of odometry.
void BM_Synchronize(benchmark::State& state) {
  WarningCounter warnings;
  std::int64_t frames = 0;
  for (auto _ : state) {
    Synchronizer synchronizer({}, {}, SensorRole::kScan, warnings);
    for (int i = 0; i < 1000; ++i) {
      const double t = 0.1 * i;
      for (int k = 0; k < 5; ++k)
        synchronizer.push({at(t + 0.02 * k), SensorRole::kOdometry, "o", 0, OdometryState{}});
      synchronizer.push({at(t + 0.08), SensorRole::kScan, "l", 0, {}});
      synchronizer.push({at(t + 0.08), SensorRole::kImage, "a", 0, {}});
      synchronizer.push({at(t + 0.09), SensorRole::kImage, "b", 0, {}});
      while (synchronizer.pop()) ++frames;
    }
  }
  state.SetItemsProcessed(frames);
}
BENCHMARK(BM_Synchronize)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace dynemo
