// The map as one cloud: the structure from all keyframes, entities where they are at a time.
#pragma once

#include <vector>

#include "class_colors.h"
#include "dynemo/exporters/export_params.h"
#include "dynemo/exporters/run_result.h"

namespace dynemo {

struct MapPoint {
  Eigen::Vector3f p_map;
  PointClass semantic_class = PointClass::kStructure;
  /// Of the point; −1 for the structure.
  std::int32_t entity = -1;
};

/// First and last time of a run: its frames, or its keyframes when it stored no frames.
Stamp firstStamp(const RunResult& run);
Stamp lastStamp(const RunResult& run);
/// The time the cloud shows.
Stamp cloudStamp(const RunResult& run, const MapCloudParams& params);

/// Points of an entity are no structure at any time, so that what moved leaves no ghosts; each
/// entity's points of all scans stand at its pose of the time. Points of what only passed by are
/// left out. Entities come first, by id, then the structure by keyframe; thinned in this order.
std::vector<MapPoint> mapCloud(const RunResult& run, const ExportParams& params);

}  // namespace dynemo
