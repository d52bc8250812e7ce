#include "dynemo/mapping/delta_builder.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "dynemo/graph/edge_floor_entity.h"
#include "dynemo/graph/edge_plane.h"
#include "dynemo/graph/edge_prior.h"
#include "dynemo/graph/edge_relative_pose.h"
#include "dynemo/graph/seen_plane.h"

namespace dynemo {

void fields(FieldVisitor& v, PlaneMappingParams& p) {
  v.flag("enabled", p.enabled, "Walls and ceilings as nodes that keyframes are tied to");
  v.section("association", p.association, "Which mapped plane an observed one is");
  v.optionalNumber("kernel_width", p.kernel_width,
                   "Cauchy width of edges to planes and floors in standard deviations",
                   Range::positive());
  v.angle("max_new_sigma_deg", p.max_new_sigma_rad,
          "A plane with a less certain normal is not mapped on its first sight", Range::positive());
  v.number("min_new_area_m2", p.min_new_area_m2,
           "A plane of which less is seen is not mapped on its first sight", Range::nonNegative());
  v.flag("regular_walls", p.regular_walls,
         "Constraints between walls that are parallel or at right angles");
  v.angle("regular_tolerance_deg", p.regular_tolerance_rad,
          "Largest deviation of regular walls at their first sight", {0.0, 45.0, true});
  v.angle("regular_sigma_deg", p.regular_sigma_rad, "Deviation of regular walls",
          Range::positive());
}

void fields(FieldVisitor& v, MappingParams& p) {
  v.flag("keyframe_entity", p.keyframe_entity,
         "Keyframe-entity constraints; without them no entity is mapped");
  v.flag("intra_entity", p.intra_entity, "Constraints between observations of one entity");
  v.flag("floor_entity", p.floor_entity, "Constant height of entities over the floor");
  v.section("motion", p.motion, "Motion models by semantic class");
  v.number("anchor_sigma_m", p.anchor_sigma_m, "Prior of the first keyframe", Range::positive());
  v.angle("anchor_sigma_deg", p.anchor_sigma_rad, "Prior of the first keyframe", Range::positive());
  v.section(
      "sweep_distortion", p.sweep_distortion,
      "Error of LiDAR odometry that registers moving sweeps as they are, from each sweep's motion");
  v.optionalNumber("odometry_kernel_width", p.odometry_kernel_width,
                   "Huber width of odometry edges in standard deviations", Range::positive());
  v.optionalNumber("detection_kernel_width", p.detection_kernel_width,
                   "Cauchy width of keyframe-entity edges in standard deviations",
                   Range::positive());
  v.number("floor_prior_sigma_m", p.floor_prior_sigma_m, "Gauge of the floor's level",
           Range::positive());
  v.number("floor_entity_sigma_m", p.floor_entity_sigma_m, "Constant height of an entity",
           Range::positive());
  v.number("height_tolerance_m", p.height_tolerance_m, "Height change of an entity that is real",
           Range::positive());
  v.section("planes", p.planes, "Walls and ceilings");
  v.section("floors", p.floors, "Storeys");
}

Matrix6 relativePoseCovariance(const Pose3& T_1, const Pose3& T_2, const MatrixX& joint) {
  Eigen::Matrix<double, 6, 12> J;
  J.leftCols<6>() = -composeJacobianLeft(T_1.inverse() * T_2);
  J.rightCols<6>() = Matrix6::Identity();
  const Matrix6 cov = J * joint * J.transpose();
  return 0.5 * (cov + cov.transpose());
}

/// One delta in the making.
class DeltaBuilder::Assembly {
 public:
  Assembly(const DeltaBuilder& builder, const CSceneGraph& graph, const KeyframeData& data)
      : builder_(builder), params_(builder.params_), graph_(graph), data_(data) {}

  GraphDelta run() {
    mergePlanes();
    addKeyframe();
    addFloor();
    addPlanes();
    if (!params_.keyframe_entity) return std::move(delta_);
    for (std::size_t i = 0; i < data_.observations.size();) {
      std::size_t end = i + 1;
      while (end < data_.observations.size() &&
             data_.observations[end].entity == data_.observations[i].entity)
        ++end;
      addEntity(i, end);
      i = end;
    }
    return std::move(delta_);
  }

 private:
  template <class Node>
  std::shared_ptr<Node> newNode() {
    auto node = std::make_shared<Node>();
    node->id = {graph_.nextNodeId().value + delta_.nodes.size()};
    delta_.nodes.push_back(node);
    return node;
  }

  void addEdge(const CEdgeBase::Ptr& edge) {
    edge->id = {graph_.nextEdgeId().value + delta_.edges.size()};
    delta_.edges.push_back(edge);
  }

  void addKeyframe() {
    keyframe_ = newNode<CNodeKeyframe>();
    keyframe_->stamp = data_.stamp;
    keyframe_->frame_index = data_.frame_index;
    keyframe_->reasons = data_.reasons;
    keyframe_->T_odom_base = data_.T_odom_base;
    keyframe_->T_map_node = keyframe_->T_map_node_first = data_.T_map_base;
    keyframe_->scan = data_.scan;
    if (graph_.keyframes().empty()) {
      auto anchor = std::make_shared<CEdgePosePrior>();
      anchor->nodes = {keyframe_->id};
      anchor->T_map_node = data_.T_map_base;
      anchor->setCovariance(isotropicCovariance(params_.anchor_sigma_m, params_.anchor_sigma_rad));
      addEdge(anchor);
      return;
    }
    const CNodeKeyframe& last = *graph_.keyframes().back();
    auto edge = std::make_shared<CEdgeOdometry>();
    edge->nodes = {last.id, keyframe_->id};
    edge->T_1_2 = last.T_odom_base.inverse() * data_.T_odom_base;
    edge->setCovariance(data_.odometry_covariance);
    if (params_.odometry_kernel_width)
      edge->kernel = {KernelType::kHuber, *params_.odometry_kernel_width};
    addEdge(edge);
  }

  /// The floor the keyframe is on, or a new one; and what the ground says of it.
  void addFloor() {
    const auto seen = groundLevel();
    const FloorChoice choice = chooseFloor(graph_, data_.T_map_base, seen, params_.floors);
    if (choice.floor) {
      floor_ = choice.floor;
    } else if (choice.new_level_m) {
      floor_ = &newFloor(*choice.new_level_m);
    }
    if (!floor_) return;
    keyframe_->floor = floor_->id;
    const Vector2 here = data_.T_map_base.t.head<2>();
    delta_.floor_areas.emplace_back(floor_->id, Eigen::AlignedBox2d(here, here));
    if (data_.ground && data_.ground_slope_rad <= params_.floors.max_slope_rad) addGround();
  }
  CNodeFloor& newFloor(double level_m) {
    auto floor = newNode<CNodeFloor>();
    floor->level_m = floor->level_first_m = level_m;
    if (!data_.ground) {
      // Nothing else holds its level against that of the entities on it.
      auto prior = std::make_shared<CEdgeFloorPrior>();
      prior->nodes = {floor->id};
      prior->level_m = level_m;
      prior->setCovariance(
          MatrixX::Constant(1, 1, params_.floor_prior_sigma_m * params_.floor_prior_sigma_m));
      addEdge(prior);
    }
    return *floor;
  }

  /// From the ground that the scan shows, or from an entity that stands on it.
  std::optional<GroundLevel> groundLevel() const {
    const double base_z_m = data_.T_map_base.t.z();
    if (data_.ground) return GroundLevel{base_z_m + data_.ground->height_m, data_.ground_slope_rad};
    const auto base_height_m = baseHeight(graph_);
    for (const EntityObservation& observation : data_.observations) {
      const EntityModel* model = builder_.models_.findEntity(observation.entity);
      if (!model || !model->origin_height_m) continue;
      const double z_m =
          (data_.T_map_base * observation.T_base_entity).t.z() - *model->origin_height_m;
      if (!base_height_m || std::abs(base_z_m - *base_height_m - z_m) <= params_.height_tolerance_m)
        return GroundLevel{z_m, 0.0};
    }
    return std::nullopt;
  }

  void addGround() {
    const PlaneObservation& ground = data_.planes[data_.ground->observation];
    auto edge = std::make_shared<CEdgeFloorGround>();
    edge->nodes = {keyframe_->id, floor_->id};
    measure(*edge, ground);
    const FloorParams& p = params_.floors;
    edge->setCovariance(ground.covariance +
                        Matrix3(Vector3(p.slope_sigma_rad, p.slope_sigma_rad, p.unevenness_sigma_m)
                                    .array()
                                    .square()
                                    .matrix()
                                    .asDiagonal()));
    addEdge(edge);
  }

  void measure(CEdgePlaneMeasurement& edge, const PlaneObservation& observation) const {
    edge.patch_base = observation.patch_base;
    edge.point_count = static_cast<std::uint32_t>(observation.points.size());
    edge.setCovariance(observation.covariance);
    if (params_.planes.kernel_width)
      edge.kernel = {KernelType::kCauchy, *params_.planes.kernel_width};
  }

  /// Level planes that face up, besides the ground, are tables and steps: things, not structure.
  bool isStructure(const PlaneObservation& observation) const {
    constexpr double kUpwards = 0.94;  // within 20 degrees
    return (data_.T_map_base.R * observation.patch_base.normal).z() < kUpwards;
  }

  void addPlanes() {
    if (!params_.planes.enabled) return;
    for (std::size_t i = 0; i < data_.planes.size(); ++i) {
      const PlaneObservation& observation = data_.planes[i];
      if (!isStructure(observation)) continue;
      const auto& known = data_.plane_association.plane;
      const auto node = i < known.size() && known[i] ? known[i] : newPlane(observation);
      if (!node) continue;
      auto edge = std::make_shared<CEdgeKeyframePlane>();
      edge->nodes = {keyframe_->id, *node};
      measure(*edge, observation);
      addEdge(edge);
      if (floor_) delta_.floor_areas.emplace_back(floor_->id, areaOf(observation));
    }
  }

  std::optional<NodeId> newPlane(const PlaneObservation& observation) {
    const double variance_rad2 = observation.covariance.topLeftCorner<2, 2>().trace();
    if (variance_rad2 > params_.planes.max_new_sigma_rad * params_.planes.max_new_sigma_rad ||
        observation.patch_base.area_m2() < params_.planes.min_new_area_m2) {
      return std::nullopt;
    }
    auto node = newNode<CNodePlane>();
    node->plane_map = node->plane_map_first = data_.T_map_base * observation.patch_base.plane();
    if (params_.planes.regular_walls) addRegularity(*node);
    return node->id;
  }

  Eigen::AlignedBox2d areaOf(const PlaneObservation& observation) const {
    Eigen::AlignedBox2d area;
    for (const Vector3& p : cellCenters(observation.patch_base, data_.T_map_base)) {
      area.extend(p.head<2>());
    }
    return area;
  }

  /// Ties a new wall to the oldest wall of its floor that is parallel or perpendicular to it.
  void addRegularity(const CNodePlane& wall) {
    constexpr double kMaxLean = 0.1;
    const double tolerance = std::sin(params_.planes.regular_tolerance_rad);
    const double variance = params_.planes.regular_sigma_rad * params_.planes.regular_sigma_rad;
    const Vector3& n = wall.plane_map.normal;
    if (std::abs(n.z()) > kMaxLean) return;
    for (const auto& other : graph_.planes()) {
      const Vector3& m = other->plane_map.normal;
      if (!isOnThisFloor(*other) || std::abs(m.z()) > kMaxLean) continue;
      CEdgeBase::Ptr edge;
      if (n.cross(m).norm() < tolerance) {
        edge = std::make_shared<CEdgePlaneParallel>();
      } else if (std::abs(n.dot(m)) < tolerance) {
        edge = std::make_shared<CEdgePlanePerpendicular>();
      } else {
        continue;
      }
      edge->nodes = {other->id, wall.id};
      edge->setCovariance(variance * MatrixX::Identity(edge->residualSize(), edge->residualSize()));
      edge->kernel = {KernelType::kCauchy, 1.0};
      addEdge(edge);
      return;
    }
  }

  bool isOnThisFloor(const CNodePlane& plane) const {
    return floor_ && floorOf(graph_, plane) == floor_->id;
  }

  /// Duplicates leave the graph; their edges go to the plane that is kept.
  void mergePlanes() {
    for (const PlaneMerge& merge : data_.plane_association.merges) {
      for (const EdgeId id : graph_.edgesOf(merge.removed)) rehang(id);
      delta_.removed_nodes.push_back(merge.removed);
    }
  }

  void rehang(EdgeId id) {
    if (std::find(delta_.removed_edges.begin(), delta_.removed_edges.end(), id) !=
        delta_.removed_edges.end()) {
      return;
    }
    const CEdgeBase& old = *graph_.edgeSlots()[id.value];
    delta_.removed_edges.push_back(id);
    const auto copy = std::dynamic_pointer_cast<CEdgeBase>(old.duplicateGetSmartPtr());
    for (NodeId& node : copy->nodes) {
      for (const PlaneMerge& m : data_.plane_association.merges) {
        if (node == m.removed) node = m.kept;
      }
    }
    // Regularity between two parts of one plane says nothing.
    if (std::set<NodeId>(copy->nodes.begin(), copy->nodes.end()).size() < copy->nodes.size())
      return;
    addEdge(copy);
  }

  /// One node for the observations [begin, end) of one entity by different sensors.
  void addEntity(std::size_t begin, std::size_t end) {
    const auto& all = data_.observations;
    const auto best = static_cast<std::size_t>(
        std::min_element(all.begin() + static_cast<std::ptrdiff_t>(begin),
                         all.begin() + static_cast<std::ptrdiff_t>(end),
                         [](const auto& a, const auto& b) {
                           return a.covariance.trace() < b.covariance.trace();
                         }) -
        all.begin());
    auto node = newNode<CNodeEntity>();
    node->entity = all[best].entity;
    node->name = all[best].name;
    node->semantic_class = all[best].semantic_class;
    node->keyframe = keyframe_->id;
    node->stamp = all[best].stamp;
    node->T_map_node = node->T_map_node_first = data_.T_map_base * all[best].T_base_entity;
    if (best < data_.fragments.size()) node->fragment = data_.fragments[best];

    for (std::size_t i = begin; i < end; ++i) addDetection(*node, all[i]);
    addMotion(*node, all[best]);
    if (params_.floor_entity && floor_) addHeight(*node);
  }

  void addDetection(const CNodeEntity& node, const EntityObservation& observation) {
    auto edge = std::make_shared<CEdgeKeyframeEntity>();
    edge->nodes = {keyframe_->id, node.id};
    edge->T_1_2 = observation.T_base_entity;
    edge->setCovariance(observation.covariance);
    if (params_.detection_kernel_width)
      edge->kernel = {KernelType::kCauchy, *params_.detection_kernel_width};
    addEdge(edge);
  }

  void addMotion(CNodeEntity& node, const EntityObservation& observation) {
    const auto track = graph_.tracks().find(node.entity);
    if (track == graph_.tracks().end()) return;
    std::vector<const CNodeEntity*> history;
    for (const auto& earlier : track->second) history.push_back(earlier.get());

    const EntityModel* model = builder_.models_.findEntity(node.entity);
    const MotionContext context{model, history, node, relativeCovariance(observation),
                                params_.intra_entity};
    const auto& motion = *builder_.motion_models_.at(motionModelName(node.semantic_class, model));
    MotionConstraint constraint = motion.constrain(context);
    node.moved = constraint.moved;
    if (!params_.intra_entity) return;
    for (const auto& edge : constraint.edges) addEdge(edge);
  }

  /// Of P = ε_{t−1}⁻¹ ε_t: the new base in the old entity's frame, then the detection.
  Matrix6 relativeCovariance(const EntityObservation& observation) const {
    const auto it = data_.relative_covariance.find(observation.entity);
    if (it == data_.relative_covariance.end()) return observation.covariance;
    const Matrix6 A = composeJacobianLeft(observation.T_base_entity);
    return A * it->second * A.transpose() + observation.covariance;
  }

  void addHeight(const CNodeEntity& node) {
    const double seen_offset_m = floor_->level_m - node.T_map_node.t.z();
    auto edge = std::make_shared<CEdgeFloorEntity>();
    edge->nodes = {floor_->id, node.id};
    edge->offset_m = heightOffset(node, seen_offset_m);
    edge->setCovariance(
        MatrixX::Constant(1, 1, params_.floor_entity_sigma_m * params_.floor_entity_sigma_m));
    edge->kernel = {KernelType::kHuber, 2.0};
    addEdge(edge);
  }

  /// z̃: from the entity file when the entity stands on the floor, else from its first observation,
  /// and anew after a confirmed change of height.
  double heightOffset(const CNodeEntity& node, double seen_offset_m) const {
    const auto near = [&](double offset_m) {
      return std::abs(offset_m - seen_offset_m) <= params_.height_tolerance_m;
    };
    const EntityModel* model = builder_.models_.findEntity(node.entity);
    if (model && model->origin_height_m && near(-*model->origin_height_m))
      return -*model->origin_height_m;
    const auto track = graph_.tracks().find(node.entity);
    if (track == graph_.tracks().end()) return seen_offset_m;
    for (auto it = track->second.rbegin(); it != track->second.rend(); ++it) {
      const auto offset_m = storedOffset(**it);
      if (offset_m) return near(*offset_m) ? *offset_m : seen_offset_m;
    }
    return seen_offset_m;
  }

  std::optional<double> storedOffset(const CNodeEntity& node) const {
    for (const EdgeId id : graph_.edgesOf(node.id)) {
      const auto* edge = dynamic_cast<const CEdgeFloorEntity*>(graph_.edgeSlots()[id.value].get());
      if (edge && edge->nodes[0] == floor_->id) return edge->offset_m;
    }
    return std::nullopt;
  }

  const DeltaBuilder& builder_;
  const MappingParams& params_;
  const CSceneGraph& graph_;
  const KeyframeData& data_;
  GraphDelta delta_;
  std::shared_ptr<CNodeKeyframe> keyframe_;
  const CNodeFloor* floor_ = nullptr;
};

DeltaBuilder::DeltaBuilder(const MappingParams& params, const EntityModels& models)
    : params_(params), models_(models) {
  for (const std::string name : {"object", "agent_line"})
    motion_models_[name] = motionModels().make(name, params.motion);
  for (const EntityModel& model : models.all()) {
    const std::string name = motionModelName(model.semantic_class, &model);
    if (!motion_models_.contains(name))
      motion_models_[name] = motionModels().make(name, params.motion);
  }
}

DeltaBuilder::~DeltaBuilder() = default;

GraphDelta DeltaBuilder::build(const CSceneGraph& graph, const KeyframeData& keyframe) const {
  return Assembly(*this, graph, keyframe).run();
}

}  // namespace dynemo
