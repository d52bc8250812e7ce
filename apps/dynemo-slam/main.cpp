// dynemo-slam: a rawlog in, a jointly optimised dynamic scene graph out.
#include <mrpt/system/COutputLogger.h>
#include <sys/resource.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <iostream>

#include "../common/program.h"
#include "../common/progress.h"
#include "config_layers.h"
#include "dynemo/core/config.h"
#include "dynemo/ingest/rawlog_source.h"
#include "dynemo/pipeline/run_folder.h"

namespace fs = std::filesystem;

namespace dynemo {
namespace {

std::atomic<bool> interrupted{false};
constexpr int kInterruptedStatus = 130;

struct Options {
  ConfigLayers config;
  std::optional<fs::path> entities, detections, rawlog, front_end_cache;
  fs::path output;
  bool dump_config = false, verbose = false, quiet = false;
};

void declare(CLI::App& app, Options& o) {
  app.add_option("RAWLOG", o.rawlog, "MRPT rawlog: LiDAR scans, camera images, odometry")
      ->type_name("");
  app.add_option("--config", o.config.file, "YAML file with the keys that differ from the defaults")
      ->type_name("FILE");
  app.add_option("--setup", o.config.setup, "Named configuration, e.g. baseline or full")
      ->type_name("NAME");
  app.add_option("--entities", o.entities, "YAML file: which tags belong to which agent or object")
      ->type_name("FILE");
  app.add_option("--detections", o.detections,
                 "CSV file with entity detections of another detector")
      ->type_name("FILE.csv");
  app.add_option("--set", o.config.overrides,
                 "Override one key, e.g. --set keyframes.timer=false (repeatable)")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  app.add_option("--output", o.output, "Folder for the results (created)")->type_name("DIR");
  app.add_option(
         "--front-end-cache", o.front_end_cache,
         "Keep LiDAR odometry and detections in this file, and take them from it when it fits "
         "the recording and the parameters")
      ->type_name("FILE");
  app.add_flag("--dump-config", o.dump_config, "Print the effective configuration and exit");
  app.add_flag("-v,--verbose", o.verbose, "Print every keyframe");
  app.add_flag("-q,--quiet", o.quiet, "Print errors only");
  app.set_version_flag("--version", "dynemo-slam " DYNEMO_VERSION);
}

void requireInputs(const Options& o) {
  if (!o.rawlog && !o.detections) throw ConfigError("RAWLOG is required (see dynemo-slam --help)");
  if (o.output.empty()) throw ConfigError("--output is required (see dynemo-slam --help)");
  if (o.verbose && o.quiet) throw ConfigError("--verbose and --quiet exclude each other");
}

RunCost measureCost(double wall_s, const IngestReport& report) {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  RunCost cost;
  cost.wall_s = wall_s;
  cost.cpu_s = seconds(usage.ru_utime) + seconds(usage.ru_stime);
  cost.peak_rss_mb = static_cast<double>(usage.ru_maxrss) / 1024.0;
  if (report.first && report.last) cost.dataset_s = secondsBetween(*report.first, *report.last);
  return cost;
}

void printSummary(const SlamPipeline& pipeline, const IngestReport& report, const RunCost& cost,
                  const fs::path& output) {
  const CSceneGraph& graph = pipeline.graph();
  std::size_t observations = 0, objects = 0, agents = 0;
  std::string moved;
  for (const auto& [id, track] : graph.tracks()) {
    observations += track.size();
    const bool agent = track.front()->semantic_class == SemanticClass::kAgent;
    ++(agent ? agents : objects);
    const bool displaced =
        std::any_of(track.begin(), track.end(), [](const auto& node) { return node->moved; });
    if (!agent && displaced) moved += (moved.empty() ? "" : ", ") + track.front()->name;
  }
  std::cout << "frames      " << report.frames << "\nkeyframes   " << graph.keyframes().size()
            << "\nentities    " << objects << " objects, " << agents << " agents, " << observations
            << " observations\nmoved       " << (moved.empty() ? "none" : moved) << "\ngraph       "
            << graph.nodeCount() << " nodes, " << graph.edgeCount() << " edges\n";
  auto warnings = report.warnings;
  for (const auto& [text, count] : pipeline.warnings()) warnings[text] += count;
  for (const auto& [text, count] : warnings)
    std::cout << "warning     " << text << ": " << count << '\n';
  for (const std::string& doubt : pipeline.doubts()) std::cout << "warning     " << doubt << '\n';
  char line[128];
  std::snprintf(line, sizeof(line),
                "time        %.1f s for %.1f s of data (%.1fx real time), %.0f MB", cost.wall_s,
                cost.dataset_s, cost.wall_s > 0 ? cost.dataset_s / cost.wall_s : 0.0,
                cost.peak_rss_mb);
  std::cout << line << "\nresults     " << output.string() << '\n';
}

/// The frames of the source through the pipeline, until the end or an interruption.
void processAll(FrameSource& source, SlamPipeline& pipeline, RunFolder& folder, Progress& progress,
                const RunIdentity& identity, double checkpoint_s) {
  std::optional<Stamp> checkpoint;
  while (!interrupted) {
    FrameTiming timing;
    std::optional<SensorFrame> frame;
    {
      const ScopedStage stage(timing, Stage::kIngest);
      frame = source.next();
    }
    if (!frame) return;
    const std::uint64_t index = frame->index;
    const Stamp stamp = frame->stamp;
    pipeline.process(std::move(*frame), timing);
    folder.frame(index, stamp, timing);
    folder.optimizations(pipeline.optimizations());
    folder.loops(pipeline.loops());
    progress.update(source.progress().fraction, source.progress().dataset_s);
    if (!checkpoint) checkpoint = stamp;
    if (secondsBetween(*checkpoint, stamp) >= checkpoint_s) {
      checkpoint = stamp;
      folder.checkpoint(pipeline, source.report(), identity);
    }
  }
}

int run(const Options& o) {
  const DynemoParams params = loadParams(o.config);
  if (o.dump_config) {
    std::cout << toYaml(params) << std::flush;
    if (!std::cout) throw DataError("standard output: cannot be written");
    return 0;
  }
  requireInputs(o);
  const EntityModels models = o.entities ? EntityModels::load(*o.entities) : EntityModels();
  const auto source = makeRawlogSource(params.sensors, o.rawlog, o.detections);
  std::optional<FrontEndCache> cache;
  SlamPipeline pipeline(params, models, source->hasOdometry());
  if (o.front_end_cache) {
    if (!o.rawlog || o.detections)
      throw ConfigError("--front-end-cache: needs a RAWLOG and no --detections");
    cache.emplace(*o.front_end_cache, frontEndIdentity(params, *o.rawlog, o.entities));
    pipeline.useCache(*cache);
  }
  RunFolder folder(o.output, params);
  Progress progress(!o.quiet);

  pipeline.logging_enable_console_output = false;
  pipeline.setMinLoggingLevel(mrpt::system::LVL_DEBUG);
  pipeline.logRegisterCallback([&](std::string_view text, const mrpt::system::VerbosityLevel level,
                                   std::string_view, const mrpt::Clock::time_point) {
    std::string line(text);
    while (!line.empty() && line.back() == '\n') line.pop_back();
    folder.log(line);
    if (o.quiet || (level < mrpt::system::LVL_WARN && !o.verbose)) return;
    progress.clear();
    std::cerr << line << '\n';
  });

  if (models.empty() && !o.detections && params.mapping.keyframe_entity) {
    pipeline.logStr(mrpt::system::LVL_WARN,
                    "no --entities and no --detections: the map will hold no entities");
  }
  RunIdentity identity{
      DYNEMO_VERSION, o.config.setup.value_or("default"),
      o.rawlog ? o.rawlog->filename().string() : o.detections->filename().string()};
  processAll(*source, pipeline, folder, progress, identity, params.checkpoint_s);
  progress.clear();
  if (cache && !interrupted) cache->finish();
  pipeline.finish();
  folder.optimizations(pipeline.optimizations());
  folder.loops(pipeline.loops());
  if (pipeline.frames().empty())
    throw DataError(identity.rawlog + ": holds no frame that could be used");

  const RunCost cost = measureCost(progress.elapsed_s(), source->report());
  folder.results(pipeline, source->report(), identity);
  folder.performance(cost);
  if (!o.quiet) printSummary(pipeline, source->report(), cost, o.output);
  return interrupted ? kInterruptedStatus : 0;
}

}  // namespace
}  // namespace dynemo

int main(int argc, char** argv) {
  for (const int signal : {SIGINT, SIGTERM}) {
    std::signal(signal, [](int) { dynemo::interrupted = true; });
  }
  CLI::App app(
      "Dynamic entity and motion-aware 3D scene graph SLAM: reads an MRPT rawlog, writes "
      "trajectory, entities "
      "and scene graph.",
      "dynemo-slam");
  dynemo::Options options;
  dynemo::declare(app, options);
  return dynemo::runProgram(app, argc, argv, [&] { return dynemo::run(options); });
}
