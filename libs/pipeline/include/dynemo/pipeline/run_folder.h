// The output folder of a run: streams that grow with it, and the results.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dynemo/core/output_file.h"
#include "dynemo/exporters/export_params.h"
#include "dynemo/ingest/frame_source.h"
#include "dynemo/pipeline/slam_pipeline.h"

namespace dynemo {

/// What the run is called in its summary.
struct RunIdentity {
  std::string version, setup, rawlog;
};

/// Wall, CPU and memory of the whole run; everything that differs between two equal runs.
struct RunCost {
  double wall_s = 0, cpu_s = 0, dataset_s = 0, peak_rss_mb = 0;
};

class RunFolder {
 public:
  /// Creates the folder and opens log.txt, timing.csv, optimizations.csv and loops.csv; writes
  /// config.yaml.
  /// Throws ConfigError for an output that does not exist, before anything is written, and
  /// DataError when the folder or a file cannot be made.
  RunFolder(const std::filesystem::path& folder, const DynemoParams& params);

  void log(const std::string& line) { log_.line(line); }
  void frame(std::uint64_t index, Stamp stamp, const FrameTiming& timing);
  /// Appends the optimisations that are not in the file yet.
  void optimizations(const std::vector<OptimizationRecord>& all);
  /// Appends the decisions about loop closures that are not in the file yet.
  void loops(const std::vector<LoopRecord>& all);

  /// Writes the light results (trajectories, entities, summary) of a run that goes on.
  void checkpoint(SlamPipeline& pipeline, const IngestReport& ingest, const RunIdentity& identity);
  /// Writes the configured outputs and summary.json. Tries every file even when one fails, then
  /// throws one DataError that lists the failures.
  void results(const SlamPipeline& pipeline, const IngestReport& ingest,
               const RunIdentity& identity);
  /// Writes performance.json: means and maxima per stage, real-time factor, memory.
  void performance(const RunCost& cost);

 private:
  void write(const std::vector<std::string>& outputs, const SlamPipeline& pipeline,
             const IngestReport& ingest, const RunIdentity& identity);

  std::vector<std::string> outputs_;
  ExportParams exports_;
  std::filesystem::path folder_;
  std::string config_yaml_;
  AppendFile log_, timing_, optimizations_, loops_;
  std::size_t optimizations_written_ = 0, loops_written_ = 0;
  double optimization_ms_ = 0, optimization_cpu_ms_ = 0;
  std::vector<FrameTiming> timings_;
};

}  // namespace dynemo
