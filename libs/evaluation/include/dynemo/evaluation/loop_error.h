// Whether the loop closures of a run are right, and how many it could have found.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "dynemo/core/ids.h"
#include "dynemo/evaluation/entity_error.h"
#include "dynemo/evaluation/trajectory.h"

namespace dynemo {

/// An accepted closure as loops.csv lists it.
struct LoopEstimate {
  EdgeId edge{};
  Stamp earlier, later;
  Pose3 T_earlier_later;
  bool removed = false;  ///< taken out again
};

/// Reads loops.csv: the closures that were ever accepted, in that order. Throws DataError, naming
/// file, line and column, when it is malformed.
std::vector<LoopEstimate> readLoopEstimates(const std::filesystem::path& file);

/// The gate that a run searched its candidates with.
struct LoopGate {
  double max_distance_m = 0.0, min_path_m = 0.0, spacing_m = 0.0;
};

/// From loops.candidates of a run's config.yaml; empty when the run closes no loops or the file
/// does not say. Throws DataError when it is no YAML.
std::optional<LoopGate> readLoopGate(const std::filesystem::path& config_yaml);

struct LoopErrorParams {
  /// A closure is right within both.
  double max_translation_m = 0.20;
  double max_rotation_rad = 0.0872664626;  // 5°
  /// Keyframes with a larger difference in height are not on one floor.
  double max_height_m = 1.0;
};

struct LoopReport {
  std::size_t closures = 0, right = 0;         ///< that stayed in the graph
  std::size_t removed = 0, removed_right = 0;  ///< that were taken out again
  std::size_t without_truth = 0;               ///< outside of the reference's span
  PoseErrorStatistics errors;                  ///< of those that stayed
  std::size_t closable = 0, recalled = 0;
  /// 1 when there is no closure.
  double precision() const;
  /// 1 when nothing could be closed; not-a-number when the gate is not known.
  double recall() const;
  bool gate_known = false;
};

/// Precision over the closures that stayed. Recall over the keyframes that could be closed: those
/// from which the gate, at the true poses, finds an earlier keyframe (within max_distance_m seen
/// from above, min_path_m of path in between); with a spacing only the first such keyframe, and
/// after it the next at least spacing_m of path later. One is recalled when a right closure starts
/// from it, or less than spacing_m later.
LoopReport evaluateLoops(const std::vector<LoopEstimate>& loops, const Trajectory& keyframes,
                         const Trajectory& reference, const std::optional<LoopGate>& gate,
                         const LoopErrorParams& params = {});

}  // namespace dynemo
