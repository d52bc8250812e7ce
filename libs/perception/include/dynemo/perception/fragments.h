#pragma once

#include <vector>

#include "dynemo/core/fields.h"
#include "dynemo/core/point_cloud.h"
#include "dynemo/perception/entity_observation.h"

namespace dynemo {

struct FragmentParams {
  double cluster_tolerance_m = 0.2;
  int min_points = 20;
  int max_points = 5000;
  double max_tag_distance_m = 0.8;   ///< objects: cluster to entity
  double agent_radius_m = 0.6;       ///< agents: vertical cylinder around the entity
};
void fields(FieldVisitor& v, FragmentParams& p);

/// The point-cloud fragment of each observation, in the order of `observations`: indices into scan.cloud, ascending;
/// empty when no cluster is near enough. KD-tree Euclidean clustering in a region around the entity; points of the
/// ground, and of large planes behind the entity, are left out.
std::vector<PointIndices> extractFragments(const Scan& scan, const std::vector<EntityObservation>& observations,
                                           const FragmentParams& params);

}  // namespace dynemo
