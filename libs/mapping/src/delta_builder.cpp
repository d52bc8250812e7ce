#include "dynemo/mapping/delta_builder.h"

#include <algorithm>
#include <cmath>

#include "dynemo/graph/edge_floor_entity.h"
#include "dynemo/graph/edge_prior.h"
#include "dynemo/graph/edge_relative_pose.h"

namespace dynemo {

void fields(FieldVisitor& v, MappingParams& p) {
  v.flag("keyframe_entity", p.keyframe_entity,
         "Keyframe-entity constraints; without them no entity is mapped");
  v.flag("intra_entity", p.intra_entity, "Constraints between observations of one entity");
  v.flag("floor_entity", p.floor_entity, "Constant height of entities over the floor");
  v.section("motion", p.motion, "Motion models by semantic class");
  v.number("anchor_sigma_m", p.anchor_sigma_m, "Prior of the first keyframe", Range::positive());
  v.angle("anchor_sigma_deg", p.anchor_sigma_rad, "Prior of the first keyframe", Range::positive());
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
    addKeyframe();
    if (!params_.keyframe_entity) return std::move(delta_);
    addFloor();
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

  /// Finds the floor, or makes the first one from the ground or from an entity of known height.
  void addFloor() {
    if (!graph_.floors().empty()) {
      floor_ = graph_.floors().back();
    } else if (const auto level_m = firstFloorLevel()) {
      auto floor = newNode<CNodeFloor>();
      floor->level_m = floor->level_first_m = *level_m;
      floor->center_map_m = data_.T_map_base.t.head<2>();
      auto prior = std::make_shared<CEdgeFloorPrior>();
      prior->nodes = {floor->id};
      prior->level_m = *level_m;
      prior->setCovariance(
          MatrixX::Constant(1, 1, params_.floor_prior_sigma_m * params_.floor_prior_sigma_m));
      addEdge(prior);
      floor_ = floor;
    }
    if (floor_) keyframe_->floor = floor_->id;
  }

  std::optional<double> firstFloorLevel() const {
    if (data_.ground_level_m) return data_.ground_level_m;
    for (const EntityObservation& observation : data_.observations) {
      const EntityModel* model = builder_.models_.findEntity(observation.entity);
      if (model && model->origin_height_m) {
        return (data_.T_map_base * observation.T_base_entity).t.z() - *model->origin_height_m;
      }
    }
    return std::nullopt;
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
  std::shared_ptr<const CNodeFloor> floor_;
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
