#include <algorithm>

#include "dynemo/core/error.h"
#include "rewriting.h"

namespace dynemo {

namespace fs = std::filesystem;

namespace {

/// One input with its next piece and the sensors seen in it.
struct Source {
  Source(const fs::path& file, WarningCounter& warnings) : reader(file, warnings), files(file) {}
  PieceReader reader;
  ExternalFiles files;
  std::optional<RawlogPiece> head;
  /// When the head is due; a piece without a stamp follows the one before it.
  Stamp due{};
  std::set<std::string> sensors;

  void advance(RewriteReport& report) {
    head = reader.next();
    if (!head) return;
    if (head->isActionsAndFrame())
      throw DataError(reader.file().string() +
                      ": has actions and sensory frames, which cannot be merged by time");
    ++report.read;
    // Out of order within an input stays so.
    if (head->stamp) due = std::max(due, *head->stamp);
    forEachObservation(*head, [&](mrpt::obs::CObservation& o) {
      sensors.insert("'" + o.sensorLabel + "' (" + shortClassName(o) + ")");
    });
  }
};

void warnOfSharedSensors(const std::vector<std::unique_ptr<Source>>& sources,
                         WarningCounter& warnings) {
  std::map<std::string, int> inputs_with;
  for (const auto& source : sources)
    for (const std::string& sensor : source->sensors) ++inputs_with[sensor];
  for (const auto& [sensor, count] : inputs_with)
    if (count > 1)
      warnings.count("sensor " + sensor + " comes from several inputs, which is right only when " +
                     "it is the same one (else relabel it first)");
}

}  // namespace

RewriteReport mergeRawlogs(const std::vector<fs::path>& inputs, const fs::path& output,
                           const RewriteOptions& options) {
  if (inputs.empty()) throw ConfigError("nothing to merge");
  RewriteReport report;
  WarningCounter warnings;
  std::vector<std::unique_ptr<Source>> sources;
  for (const fs::path& input : inputs)
    sources.push_back(std::make_unique<Source>(input, warnings));
  RawlogOutput out(output, options.compressed.value_or(sources.front()->reader.compressed()),
                   options.images);
  for (const auto& source : sources) source->advance(report);
  while (true) {
    Source* next = nullptr;
    for (const auto& source : sources)
      if (source->head && (next == nullptr || source->due < next->due)) next = source.get();
    if (next == nullptr) break;
    out.write(std::move(*next->head), next->files, warnings);
    next->advance(report);
  }
  warnOfSharedSensors(sources, warnings);
  out.commit();
  report.written = out.objectsWritten();
  report.warnings = warnings.counts();
  report.files = {output};
  return report;
}

}  // namespace dynemo
