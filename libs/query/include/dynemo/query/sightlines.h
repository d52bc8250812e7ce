// What a scan says of a place: whether something stands there or the rays go through.
#pragma once

#include <optional>
#include <vector>

#include "dynemo/query/entity_extent.h"
#include "dynemo/query/persistence.h"
#include "dynemo/query/query_params.h"
#include "dynemo/query/stays.h"

namespace dynemo {

struct RayCount {
  int hits = 0;     ///< end inside the box
  int through = 0;  ///< pass it and end behind
};

/// Rays of a scan from T_entity_lidar that meet the box, which is shrunk a little: poses are not
/// exact. Rays that end in front of it say nothing.
RayCount countRays(const PointCloud& cloud, const Pose3& T_entity_lidar, const Extent& extent);

/// P(scan | object there) / P(scan | gone) of the counted rays; empty when they are too few or
/// undecided.
std::optional<double> likelihoodRatio(const RayCount& rays, const QueryParams& params);

/// The keyframes' scans between two stamps (both excluded) that say something of an object at a
/// place, in seconds after `from`, ascending.
std::vector<Look> looksAt(const CSceneGraph& graph, const Pose3& T_map_entity, const Extent& extent,
                          Stamp from, Stamp to, const QueryParams& params);

/// How often the place of an object looks empty to scans while it is there, by those of the times
/// in which it is known to be, from the first to the last sighting of each stay. Objects of which
/// parts were taken that are not theirs, or through which rays pass, are missed more often.
double missedProbability(const CSceneGraph& graph, const std::vector<Stay>& stays,
                         const Extent& extent, const QueryParams& params);

}  // namespace dynemo
