// Turns a keyframe and its observations into nodes and edges (paper, Sec. IV-A), without touching
// the graph.
#pragma once

#include <map>
#include <memory>
#include <vector>

#include "dynemo/core/fields.h"
#include "dynemo/entities/motion_model.h"
#include "dynemo/graph/scene_graph.h"
#include "dynemo/mapping/floors.h"
#include "dynemo/mapping/ground_plane.h"
#include "dynemo/mapping/odometry_noise.h"
#include "dynemo/mapping/plane_association.h"
#include "dynemo/perception/entity_observation.h"

namespace dynemo {

struct PlaneMappingParams {
  bool enabled = true;
  PlaneAssociationParams association;
  /// Cauchy width of keyframe–plane and floor–ground edges in standard deviations; none when empty.
  std::optional<double> kernel_width = 3.0;
  /// A plane that is less certain in its normal, or smaller, is not mapped on its first sight.
  double max_new_sigma_rad = 0.02;
  double min_new_area_m2 = 1.5;
  /// Edges between walls of a floor that are parallel or at right angles up to the tolerance.
  bool regular_walls = false;
  double regular_tolerance_rad = 0.026;
  double regular_sigma_rad = 0.009;
};
void fields(FieldVisitor& v, PlaneMappingParams& p);

struct MappingParams {
  /// Which constraints of the paper are built; without the first there are no entity nodes at all.
  bool keyframe_entity = true;
  bool intra_entity = true;
  bool floor_entity = true;
  MotionParams motion;

  double anchor_sigma_m = 1e-3;
  double anchor_sigma_rad = 1e-3;
  /// For LiDAR odometry that knows no deskewing.
  SweepDistortionParams sweep_distortion;
  /// Huber width of odometry edges in standard deviations; none when empty.
  std::optional<double> odometry_kernel_width = 1.5;
  /// Cauchy width of keyframe–entity edges in standard deviations; none when empty.
  std::optional<double> detection_kernel_width = 3.0;

  double floor_prior_sigma_m = 0.01;
  double floor_entity_sigma_m = 0.05;
  /// An entity this far off its known height does not stand on the floor; and a height change that
  /// is real.
  double height_tolerance_m = 0.15;

  PlaneMappingParams planes;
  FloorParams floors;
};
void fields(FieldVisitor& v, MappingParams& p);

/// A frame that was chosen as keyframe, with everything the builder needs.
struct KeyframeData {
  Stamp stamp;
  std::uint64_t frame_index = 0;
  std::uint32_t reasons = 0;
  Pose3 T_odom_base;
  /// Initial estimate.
  Pose3 T_map_base;
  /// Of the right tangent of the odometry since the previous keyframe.
  Matrix6 odometry_covariance = Matrix6::Identity();
  std::shared_ptr<const Scan> scan;
  /// Planes of the scan, and the mapped planes that they are of.
  std::vector<PlaneObservation> planes;
  PlaneAssociation plane_association;
  /// Which of the planes is the ground under the robot, when seen.
  std::optional<GroundPlane> ground;
  /// How certainly the ground is off the level.
  double ground_slope_rad = 0.0;
  /// Ordered by entity; several sensors may see the same one.
  std::vector<EntityObservation> observations;
  /// Fragment of each observation.
  std::vector<PointIndices> fragments;
  /// Per re-observed entity: covariance of T_previous_base, the new base in the frame of the
  /// entity's last node.
  std::map<EntityId, Matrix6> relative_covariance;
};

class DeltaBuilder {
 public:
  /// The models must outlive the builder. Throws ConfigError when an entity names an unknown motion
  /// model.
  DeltaBuilder(const MappingParams& params, const EntityModels& models);
  ~DeltaBuilder();

  /// Pure: the same graph and keyframe give the same delta.
  GraphDelta build(const CSceneGraph& graph, const KeyframeData& keyframe) const;

 private:
  class Assembly;
  MappingParams params_;
  const EntityModels& models_;
  std::map<std::string, std::unique_ptr<MotionModel>> motion_models_;
};

/// Covariance of the right tangent of T_1⁻¹ T_2 from the joint covariance (12×12) of both poses'
/// tangents.
Matrix6 relativePoseCovariance(const Pose3& T_1, const Pose3& T_2, const MatrixX& joint);

}  // namespace dynemo
