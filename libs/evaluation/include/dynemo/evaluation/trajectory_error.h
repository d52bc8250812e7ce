// Absolute and relative trajectory errors, as the evo tools define them
// (github.com/MichaelGrupp/evo; J. Sturm et al., "A Benchmark for the Evaluation of RGB-D SLAM
// Systems", IROS 2012).
#pragma once

#include <cstddef>
#include <vector>

#include "dynemo/evaluation/alignment.h"
#include "dynemo/evaluation/statistics.h"

namespace dynemo {

struct AssociationParams {
  double max_difference_s = 0.01;
};

/// Two trajectories pose by pose: reference[i] and estimate[i] belong together, the estimate
/// already in the frame of the reference.
struct AlignedTrajectories {
  Trajectory reference;
  Trajectory estimate;
  Pose3 T_reference_estimate;
};

/// Associates and aligns, as `evo_ape tum REF EST -a` does.
Expected<AlignedTrajectories, AlignmentFailure> alignTrajectories(
    const Trajectory& reference, const Trajectory& estimate, const AssociationParams& params = {});

/// Distances between the positions of each pair [m]: the absolute trajectory error.
Statistics absoluteTranslationError(const AlignedTrajectories& aligned);

/// How relativePoseErrors() chooses its pairs of poses.
struct RelativePoseParams {
  enum class Unit { kMeters, kFrames };
  Unit unit = Unit::kMeters;
  /// Path length along the estimate [m], or number of frames, between the two poses of a pair.
  double delta = 1.0;
  /// Accepted deviation of the path length, as a share of delta.
  double tolerance = 0.1;
};

struct RelativePoseErrors {
  Statistics translation_m;
  Statistics rotation_rad;
};

/// Errors E = (Q_i⁻¹ Q_j)⁻¹ (P_i⁻¹ P_j) over all pairs (i, j), Q the reference and P the estimate:
/// for each i the j whose path length from i is nearest to delta (evo_rpe --all_pairs).
RelativePoseErrors relativePoseErrors(const AlignedTrajectories& aligned,
                                      const RelativePoseParams& params);

}  // namespace dynemo
