#pragma once

#include <optional>
#include <vector>

#include "dynemo/graph/scene_graph.h"
#include "dynemo/perception/entity_observation.h"

namespace dynemo {

/// T_map_base from the mapped entities in view, taken as unmoved: a robust least-squares fusion of
/// one pose per observation, weighted by its covariance. Objects are used, and agents only when no
/// object is seen that is mapped. Empty when no observed entity is mapped. For frames without
/// odometry.
std::optional<Pose3> localizeFromEntities(const std::vector<EntityObservation>& observations,
                                          const CSceneGraph& graph);

}  // namespace dynemo
