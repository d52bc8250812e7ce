#include <mrpt/maps/CPointsMap.h>
#include <mrpt/obs/CObservationPointCloud.h>

#include "dynemo/core/error.h"
#include "rewriting.h"

namespace dynemo {
namespace {

/// Returns whether the observation has a cloud of its own that could be thinned.
bool thinPoints(mrpt::obs::CObservation& observation, std::uint64_t keep_every) {
  auto* scan = dynamic_cast<mrpt::obs::CObservationPointCloud*>(&observation);
  if (scan == nullptr || !scan->pointcloud) return false;
  std::vector<bool> doomed(scan->pointcloud->size());
  for (std::size_t i = 0; i < doomed.size(); ++i) doomed[i] = i % keep_every != 0;
  scan->pointcloud->applyDeletionMask(doomed);
  return true;
}

}  // namespace

RewriteReport decimateRawlog(const std::filesystem::path& input,
                             const std::filesystem::path& output, const Decimation& decimation,
                             const RewriteOptions& options) {
  if (decimation.keep_every < 1 || decimation.keep_points_every < 1)
    throw ConfigError("only every n-th with n ≥ 1 can be kept");
  if (decimation.keep_every == 1 && decimation.keep_points_every == 1)
    throw ConfigError("nothing to thin: --keep-every or --keep-points-every must be > 1");
  LabelCheck labels(decimation.labels);
  std::map<std::pair<std::string, std::string>, std::uint64_t> seen;
  const auto edit = [&](mrpt::obs::CObservation& o) {
    if (!labels.wants(o.sensorLabel) && !decimation.labels.empty()) return EditResult::kUnchanged;
    const auto index = seen[{o.sensorLabel, shortClassName(o)}]++;
    if (index % decimation.keep_every != 0) return EditResult::kDropped;
    const bool thinned =
        decimation.keep_points_every > 1 && thinPoints(o, decimation.keep_points_every);
    return thinned ? EditResult::kEdited : EditResult::kUnchanged;
  };
  return rewriteObservations(input, output, options, edit,
                             [&](const RewriteReport&) { labels.requireAll(input); });
}

}  // namespace dynemo
