// trim and split.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "dynemo/core/error.h"
#include "rewriting.h"

namespace dynemo {

namespace fs = std::filesystem;

namespace {

/// All parts are open at a time.
constexpr std::int64_t kMostParts = 500;
constexpr double kShortestPart_s = 1e-3;

/// What fits into a stamp.
constexpr double kMost_s = 9.0e9;

std::int64_t nanoseconds(double seconds) { return std::llround(seconds * 1e9); }

void requireTime(const std::optional<double>& seconds) {
  if (seconds && !(std::abs(*seconds) < kMost_s))
    throw ConfigError("the range must be given in seconds, between -9e9 and 9e9");
}

/// Why nothing is left, to one who may have mistaken the zero of the times.
std::string nothingInRange(const fs::path& input, const std::optional<Stamp>& first,
                           const std::optional<Stamp>& last, bool unix_time) {
  std::string text = input.string() + ": nothing lies in the range that is to be kept";
  if (!first) return text;
  char length[32];
  std::snprintf(length, sizeof(length), "%.3f", secondsBetween(*first, *last));
  text += "; the log lasts " + std::string(length) + " s from " + first->text();
  return text + (unix_time ? ", and the range is in UNIX time" : ", which is the range's zero");
}

fs::path partName(const fs::path& output, std::int64_t index) {
  char number[32];
  std::snprintf(number, sizeof(number), "_%02lld", static_cast<long long>(index + 1));
  return output.parent_path() / (output.stem().string() + number + output.extension().string());
}

/// Which part a piece belongs to: counted from the first stamp of the log; a piece without a stamp
/// goes with the one before it.
class PartIndex {
 public:
  explicit PartIndex(double duration_s) : duration_ns_(nanoseconds(duration_s)) {}
  std::int64_t of(const RawlogPiece& piece) {
    if (!piece.stamp) return last_;
    if (!first_) first_ = *piece.stamp;
    // Observations from before the first one in the file belong to the first part.
    last_ = std::max<std::int64_t>(0, (piece.stamp->ns - first_->ns) / duration_ns_);
    return last_;
  }

 private:
  std::int64_t duration_ns_, last_ = 0;
  std::optional<Stamp> first_;
};

}  // namespace

RewriteReport trimRawlog(const fs::path& input, const fs::path& output, const TimeRange& range,
                         const RewriteOptions& options) {
  requireTime(range.from_s);
  requireTime(range.to_s);
  if (range.from_s && range.to_s && *range.to_s <= *range.from_s)
    throw ConfigError("the end of the range must come after its beginning");
  RewriteReport report;
  WarningCounter warnings;
  PieceReader reader(input, warnings);
  RawlogOutput out(output, options.compressed.value_or(reader.compressed()), options.images);
  std::optional<Stamp> zero, first, last;
  if (range.unix_time) zero = Stamp{0};
  bool inside = !range.from_s;
  const auto route = [&](RawlogPiece& piece) -> RawlogOutput* {
    if (piece.stamp) {
      if (!zero) zero = *piece.stamp;
      if (!first) first = *piece.stamp;
      last = std::max(last.value_or(*piece.stamp), *piece.stamp);
      const std::int64_t t_ns = piece.stamp->ns - zero->ns;
      inside = (!range.from_s || t_ns >= nanoseconds(*range.from_s)) &&
               (!range.to_s || t_ns < nanoseconds(*range.to_s));
    }
    return inside ? &out : nullptr;
  };
  rewrite(reader, route, warnings, report);
  report.written = out.objectsWritten();
  if (report.written == 0) throw DataError(nothingInRange(input, first, last, range.unix_time));
  out.commit();
  report.warnings = warnings.counts();
  report.files = {output};
  return report;
}

RewriteReport splitRawlog(const fs::path& input, const fs::path& output, double duration_s,
                          const RewriteOptions& options) {
  if (!(duration_s >= kShortestPart_s && duration_s < kMost_s))
    throw ConfigError("the duration of a part must be at least 1 ms");
  RewriteReport report;
  WarningCounter warnings;
  PieceReader reader(input, warnings);
  const bool compressed = options.compressed.value_or(reader.compressed());
  PartIndex part_index(duration_s);
  std::map<std::int64_t, std::unique_ptr<RawlogOutput>> parts;
  const auto route = [&](RawlogPiece& piece) {
    const std::int64_t index = part_index.of(piece);
    if (index >= kMostParts)
      throw ConfigError("more than " + std::to_string(kMostParts) +
                        " parts: choose a longer duration");
    auto& part = parts[index];
    if (!part)
      part = std::make_unique<RawlogOutput>(partName(output, index), compressed, options.images);
    return part.get();
  };
  rewrite(reader, route, warnings, report);
  if (parts.empty()) throw DataError(input.string() + ": holds nothing that could be split");
  for (const auto& [index, part] : parts) {
    part->commit();
    report.written += part->objectsWritten();
    report.files.push_back(part->file());
  }
  report.warnings = warnings.counts();
  return report;
}

}  // namespace dynemo
