#pragma once

#include <filesystem>

#include "dynemo/core/registry.h"
#include "dynemo/exporters/run_result.h"

namespace dynemo {

/// Writes one format. A new format is one file and one line in register.cpp.
class Exporter {
 public:
  virtual ~Exporter() = default;
  /// File name inside a run folder, e.g. "trajectory.tum".
  virtual std::string fileName() const = 0;
  /// Writes the file completely or not at all. Throws DataError when it cannot be written.
  virtual void write(const RunResult& run, const std::filesystem::path& file) const = 0;
};

/// By name as in the configuration's `outputs`: trajectory, keyframes, odometry, entities, g2o,
/// graph, 3dscene, map.
using ExporterRegistry = Registry<Exporter>;
const ExporterRegistry& exporters();

}  // namespace dynemo
