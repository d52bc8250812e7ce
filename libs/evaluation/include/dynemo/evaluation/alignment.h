// Association by time and rigid alignment of two trajectories.
#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "dynemo/core/error.h"
#include "dynemo/evaluation/trajectory.h"

namespace dynemo {

/// Indices of a reference pose and of an estimated pose of nearly the same stamp.
struct PosePair {
  std::size_t reference = 0;
  std::size_t estimate = 0;
};

/// For each stamp of the shorter trajectory (the estimate, when both are as long) the nearest of
/// the other, where it is at most max_difference_s away: the rule of evo
/// (github.com/MichaelGrupp/evo, sync.associate_trajectories).
std::vector<PosePair> associate(const Trajectory& reference, const Trajectory& estimate,
                                double max_difference_s);

enum class AlignmentFailure {
  kTooFewPoints,  ///< fewer than three pairs
  kDegenerate     ///< all points of one list on one line: the rotation is not determined
};

const char* alignmentFailureText(AlignmentFailure failure);

/// The rigid motion T_reference_estimate, without scale, that minimises Σ ‖reference − T ·
/// estimate‖². S. Umeyama, "Least-squares estimation of transformation parameters between two point
/// patterns", PAMI 13(4), 1991, Eqs. (34)–(43) with c = 1.
Expected<Pose3, AlignmentFailure> alignPoints(std::span<const Vector3> reference,
                                              std::span<const Vector3> estimate);

/// The same trajectory seen from the reference frame: T_reference_estimate · T.
Trajectory transformed(const Trajectory& trajectory, const Pose3& T_reference_estimate);

}  // namespace dynemo
