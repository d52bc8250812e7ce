// The whole system on the bundled sample, by source of odometry; time per frame and stage as
// counters.
#include <benchmark/benchmark.h>

#include <filesystem>

#include "dynemo/ingest/rawlog_source.h"
#include "dynemo/pipeline/slam_pipeline.h"

namespace dynemo {
namespace {

void wholeRun(benchmark::State& state, OdometrySource odometry) {
  const std::filesystem::path folder =
      std::filesystem::path(DYNEMO_SAMPLE_RAWLOGS) / "rooms_agents";
  const EntityModels models = EntityModels::load(folder / "rooms_agents_entities.yaml");
  DynemoParams params;
  params.odometry.source = odometry;
  params.odometry.lidar.threads = 1;
  FrameTiming sum;
  double frames = 0;
  for (auto _ : state) {
    const auto source = makeRawlogSource(params.sensors, folder / "rooms_agents.rawlog");
    SlamPipeline pipeline(params, models, source->hasOdometry());
    while (true) {
      FrameTiming timing;
      std::optional<SensorFrame> frame;
      {
        const ScopedStage stage(timing, Stage::kIngest);
        frame = source->next();
      }
      if (!frame) break;
      pipeline.process(std::move(*frame), timing);
      for (std::size_t s = 0; s < timing.ms.size(); ++s) sum.ms[s] += timing.ms[s];
      ++frames;
    }
    pipeline.finish();
  }
  for (std::size_t s = 0; s < sum.ms.size(); ++s)
    state.counters[std::string(kStageNames[s]) + "_ms"] = sum.ms[s] / frames;
  state.counters["frame_ms"] = sum.total() / frames;
}

BENCHMARK_CAPTURE(wholeRun, rawlog_odometry, OdometrySource::kRawlog)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(wholeRun, lidar_odometry, OdometrySource::kLidar)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace dynemo
