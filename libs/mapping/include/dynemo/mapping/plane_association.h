// Which mapped plane each plane of a new keyframe is.
#pragma once

#include <optional>
#include <vector>

#include "dynemo/core/fields.h"
#include "dynemo/mapping/keyframe_prediction.h"
#include "dynemo/perception/plane_extractor.h"

namespace dynemo {

struct PlaneAssociationParams {
  /// Chi-square(3) probability up to which a difference is noise.
  double gate_probability = 0.999;
  /// Whatever the uncertainty, planes further apart than this are not compared.
  double max_angle_rad = 0.26;
  double max_offset_m = 0.5;
  /// How far apart the seen parts of one plane may be.
  double max_gap_m = 5.0;
  /// Of two faces that look the same way, one behind the other, the front one would hide the other.
  /// A plane that covers a mapped one is that one up to this offset, however certain both are: the
  /// robot has slipped.
  double max_slip_m = 0.15;
  /// Least share of the plane that covers what was seen of the mapped one.
  double min_cover = 0.6;
  /// Added to every comparison: walls are not quite flat.
  double flatness_sigma_m = 0.01;
  double flatness_sigma_rad = 0.005;
};
void fields(FieldVisitor& v, PlaneAssociationParams& p);

/// Two nodes that turned out to be the same plane.
struct PlaneMerge {
  NodeId kept{}, removed{};
};

struct PlaneAssociation {
  /// Per observation, the mapped plane it is of; empty for one that is not mapped.
  std::vector<std::optional<NodeId>> plane;
  std::vector<PlaneMerge> merges;
  /// Error of the motion since the last keyframe that covered planes have shown, beyond what it
  /// claims: covariance of the right tangent.
  Matrix6 slip = Matrix6::Zero();
};

/// Mapped planes that the observations could be of by angle, offset and overlap alone; ascending.
/// What associatePlanes() needs to know the uncertainty of.
std::vector<NodeId> planeCandidates(const CSceneGraph& graph, const Pose3& T_map_base,
                                    const std::vector<PlaneObservation>& observations,
                                    const PlaneAssociationParams& params);

/// The candidate nearest by Mahalanobis distance, or when none is near, one that is covered; with the joint uncertainty of robot and plane,
/// whose seen part overlaps or adjoins the observed one; planes face one side, so that the two
/// faces of a thin wall stay apart. Several candidates that agree with the observation and with
/// each other are duplicates, to be merged into the oldest.
PlaneAssociation associatePlanes(const CSceneGraph& graph, const KeyframePrediction& prediction,
                                 const std::vector<PlaneObservation>& observations,
                                 const PlaneAssociationParams& params);

}  // namespace dynemo
