// The points of a scan that belong to each observed entity.
#pragma once

#include <vector>

#include "dynemo/core/fields.h"
#include "dynemo/core/point_cloud.h"
#include "dynemo/perception/entity_model.h"
#include "dynemo/perception/entity_observation.h"

namespace dynemo {

struct FragmentParams {
  double cluster_tolerance_m = 0.2;
  int min_points = 20;
  int max_points = 5000;
  double max_tag_distance_m = 0.8;  ///< objects: cluster to entity
  double agent_radius_m = 0.6;      ///< agents: vertical cylinder around the entity
  double region_radius_m = 1.0;     ///< only this far around an entity is looked at
  double ground_tolerance_m = 0.05;
  double plane_tolerance_m = 0.04;
  double plane_min_length_m = 1.2;  ///< a narrower upright plane may be a face of the entity
};
void fields(FieldVisitor& v, FragmentParams& p);

/// What helps to find the ground under an entity.
struct FragmentContext {
  const EntityModels* models = nullptr;  ///< for the height of an entity's origin over the ground
  /// Unit vector away from the ground, in the base frame; an error of some degrees does no harm.
  Vector3 up_base = Vector3::UnitZ();
};

/// The point-cloud fragment of each observation, in the order of `observations`: indices into
/// scan.cloud, ascending; empty when no cluster is near enough. KD-tree Euclidean clustering in a
/// region around the entity; points of the ground, and of large planes behind the entity, are left
/// out.
std::vector<PointIndices> extractFragments(const Scan& scan,
                                           const std::vector<EntityObservation>& observations,
                                           const FragmentParams& params,
                                           const FragmentContext& context = {});

}  // namespace dynemo
