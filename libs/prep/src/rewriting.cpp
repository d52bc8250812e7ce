#include "rewriting.h"

#include "dynemo/core/error.h"

namespace dynemo {

namespace fs = std::filesystem;

void rewrite(PieceReader& input, const Route& route, WarningCounter& warnings,
             RewriteReport& report) {
  const ExternalFiles files(input.file());
  while (auto piece = input.next()) {
    report.read += piece->objects.size();
    RawlogOutput* output = route(*piece);
    if (output != nullptr) output->write(std::move(*piece), files, warnings);
  }
}

RewriteReport rewriteObservations(const fs::path& input, const fs::path& output,
                                  const RewriteOptions& options, const ObservationEdit& edit,
                                  const std::function<void(const RewriteReport&)>& check) {
  RewriteReport report;
  WarningCounter warnings;
  PieceReader reader(input, warnings);
  RawlogOutput out(output, options.compressed.value_or(reader.compressed()), options.images);
  const auto counting_edit = [&](mrpt::obs::CObservation& o) {
    const std::string label = o.sensorLabel;  // which the edit may change
    const EditResult result = edit(o);
    if (result == EditResult::kEdited) ++report.edited[label];
    return result;
  };
  rewrite(
      reader,
      [&](RawlogPiece& piece) { return editObservations(piece, counting_edit) ? &out : nullptr; },
      warnings, report);
  if (check) check(report);
  out.commit();
  report.written = out.objectsWritten();
  report.warnings = warnings.counts();
  report.files = {output};
  return report;
}

void LabelCheck::requireAll(const fs::path& input) const {
  std::string missing, known;
  for (const std::string& label : wanted_)
    if (!seen_.contains(label)) missing += (missing.empty() ? "'" : ", '") + label + "'";
  for (const std::string& label : seen_) known += (known.empty() ? "'" : ", '") + label + "'";
  if (!missing.empty())
    throw ConfigError(input.string() + ": no sensor " + missing + "; it has " + known);
}

}  // namespace dynemo
