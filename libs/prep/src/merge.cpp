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
  /// First and last stamp of each sensor.
  std::map<std::string, std::pair<Stamp, Stamp>> sensors;

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
      const std::string name = "'" + o.sensorLabel + "' (" + shortClassName(o) + ")";
      sensors.try_emplace(name, due, due).first->second.second = due;
    });
  }
};

/// Parts of one recording follow each other; the same sensor twice at a time is two sensors.
void warnOfSharedSensors(const std::vector<std::unique_ptr<Source>>& sources,
                         WarningCounter& warnings) {
  for (std::size_t a = 0; a < sources.size(); ++a)
    for (std::size_t b = a + 1; b < sources.size(); ++b)
      for (const auto& [sensor, times] : sources[a]->sensors) {
        const auto other = sources[b]->sensors.find(sensor);
        if (other == sources[b]->sensors.end() || other->second.first > times.second ||
            other->second.second < times.first)
          continue;
        warnings.count("sensor " + sensor +
                       " comes from several inputs at the same time: relabel " +
                       "one, unless it is the same sensor");
      }
}

}  // namespace

RewriteReport mergeRawlogs(const std::vector<fs::path>& inputs, const fs::path& output,
                           const RewriteOptions& options) {
  if (inputs.empty()) throw ConfigError("nothing to merge");
  RewriteReport report;
  WarningCounter warnings;
  std::vector<std::unique_ptr<Source>> sources;
  for (const fs::path& input : inputs) sources.push_back(std::make_unique<Source>(input, warnings));
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
