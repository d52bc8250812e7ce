#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dynemo/core/registry.h"
#include "dynemo/exporters/export_params.h"
#include "dynemo/exporters/run_result.h"

namespace dynemo {

/// Writes one format. A new format is one file and one line in register.cpp.
class Exporter {
 public:
  virtual ~Exporter() = default;
  /// File name inside a run folder, e.g. "trajectory.tum". Formats of several files have a folder.
  virtual std::string fileName() const = 0;
  /// Ends of file names that readers of the format know, with the dot; none for a folder.
  virtual std::vector<std::string> extensions() const;
  /// Writes the file (or folder) completely or not at all. Throws DataError when it cannot be
  /// written.
  virtual void write(const RunResult& run, const std::filesystem::path& file) const = 0;
};

/// By name as in the configuration's `outputs` and in dynemo-export's --format.
using ExporterRegistry = Registry<Exporter, const ExportParams&>;
const ExporterRegistry& exporters();

/// Throws ConfigError when a name ends as files of other formats do (".ply" for the format "png"),
/// which would mislead every reader. Other endings, and none, are the user's own.
void checkFileName(const std::string& format, const std::filesystem::path& file);

}  // namespace dynemo
