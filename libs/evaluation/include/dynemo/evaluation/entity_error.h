// How far the entities of a run are from where they were.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "dynemo/evaluation/placements.h"
#include "dynemo/evaluation/statistics.h"

namespace dynemo {

struct PoseError {
  double translation_m = 0.0;
  double rotation_rad = 0.0;
};

/// Distance and rotation angle between two poses given in the same frame.
PoseError poseError(const Pose3& T_truth, const Pose3& T_estimate);

struct PoseErrorStatistics {
  Statistics translation_m;
  Statistics rotation_rad;
};

PoseErrorStatistics summarize(const std::vector<PoseError>& errors);

/// One entity node against the ground truth at its stamp.
struct EntityNodeError {
  EntityEstimate estimate;
  Pose3 T_world_entity;            ///< ground truth
  Pose3 T_world_entity_estimated;  ///< after the last optimisation
  PoseError first;                 ///< when the node was created
  PoseError final;                 ///< after the last optimisation
  std::optional<std::size_t> placement;
  /// Normalised estimation error squared, eᵀ Σ⁻¹ e with e the tangent from estimate to truth: χ²
  /// with 6 degrees of freedom when the covariance is consistent (Y. Bar-Shalom et al., "Estimation
  /// with Applications to Tracking and Navigation", 2001, Sec. 5.4). The alignment takes the common
  /// gauge out of e but not out of Σ.
  std::optional<double> nees;
};

/// One object while it stayed in one place.
struct PlacementError {
  EntityId entity{};
  std::size_t placement = 0;
  std::size_t nodes = 0;
  PoseError last;    ///< final estimate of the last node of the placement
  PoseError median;  ///< medians over the final estimates of all its nodes
};

struct EntitySummary {
  SemanticClass semantic_class = SemanticClass::kObject;
  std::string name;
  PoseErrorStatistics first, final;
};

struct EntityErrors {
  std::vector<EntityNodeError> nodes;
  /// Estimates of entities or times that the ground truth does not cover.
  std::size_t without_truth = 0;
  std::map<EntityId, EntitySummary> entities;
  std::vector<PlacementError> placements;
};

/// T_world_map is the alignment of the run's own trajectory
/// (AlignedTrajectories::T_reference_estimate).
EntityErrors evaluateEntities(const std::vector<EntityEstimate>& estimates,
                              const EntityTruths& truths, const Pose3& T_world_map,
                              const PlacementParams& params = {});

/// Errors of all nodes of one class when created and at the end.
PoseErrorStatistics firstErrors(const EntityErrors& errors, SemanticClass semantic_class);
PoseErrorStatistics finalErrors(const EntityErrors& errors, SemanticClass semantic_class);

/// Over all placements of all objects.
PoseErrorStatistics placementErrors(const EntityErrors& errors);

struct NeesSummary {
  std::size_t count = 0;
  double mean = Statistics::kNone;
  /// Share of nodes under the χ² quantile of 6 degrees of freedom at `probability`.
  double share_inside = Statistics::kNone;
  double probability = 0.95;
};

NeesSummary neesSummary(const EntityErrors& errors, SemanticClass semantic_class);

}  // namespace dynemo
