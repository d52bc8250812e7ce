// Whether a run noticed what moved, and how well it measured the motions.
#pragma once

#include <vector>

#include "dynemo/evaluation/entity_error.h"

namespace dynemo {

/// Counts of a binary classification.
struct DetectionCounts {
  std::size_t true_positives = 0, false_positives = 0, false_negatives = 0;

  /// Share of what was reported that is true; 1 when nothing was reported.
  double precision() const;
  /// Share of what is true that was reported; 1 when nothing was to be reported.
  double recall() const;
  /// Harmonic mean of the two.
  double f1() const;
};

struct ChangeParams {
  /// Displacement between two consecutive observations from which an object has moved (either one).
  double min_translation_m = 0.1;
  double min_rotation_rad = 0.1;
  /// Distance within which an estimated object is the true one.
  double max_object_distance_m = 0.5;
};

/// One object seen over the run.
struct ObjectChange {
  EntityId entity{};
  bool truly_moved = false;     ///< between two of its observations
  bool reported_moved = false;  ///< by the flag of any of its nodes
};

struct ChangeReport {
  std::vector<ObjectChange> objects;
  /// Per object over the whole run.
  DetectionCounts by_object;
  /// Per pair of consecutive observations of an object.
  DetectionCounts by_observation;
  /// Objects at the end of the run (M. Schmid et al., "Khronos", RSS 2024): found when the last
  /// node lies within max_object_distance_m of where the object is then, missed when it was never
  /// seen or lies elsewhere.
  DetectionCounts objects_at_end;
};

ChangeReport evaluateChanges(const EntityErrors& errors, const EntityTruths& truths,
                             const ChangeParams& params = {});

/// Motion errors over consecutive observations of entities, as DynoSAM defines them (J. Morris et
/// al., "DynoSAM", 2025): with H = L_k L_{k−1}⁻¹ the motion of a pose L in the world frame, hat =
/// estimated,
///   ME  = H⁻¹ Ĥ, which grows with the distance from the origin;
///   RME = L_k⁻¹ Ĥ L_{k−1} with the true poses L, the error in the entity's own frame.
struct MotionErrors {
  PoseErrorStatistics me;
  PoseErrorStatistics rme;
};

MotionErrors evaluateMotions(const EntityErrors& errors, SemanticClass semantic_class);

}  // namespace dynemo
