#include "dynemo/pipeline/frame_refinement.h"

#include "dynemo/core/noise.h"
#include "dynemo/graph/edge_agent_motion.h"
#include "dynemo/graph/edge_prior.h"
#include "dynemo/graph/edge_relative_pose.h"

namespace dynemo {
namespace {

/// The keyframes are where the graph has them.
constexpr double kFixed_m = 1e-5, kFixed_rad = 1e-5;

/// Where an object stood between keyframe number `keyframe` and the next one; nullptr when it was
/// moved in between, or is not in the graph around that time.
const CNodeEntity* placeOf(const CSceneGraph& graph, EntityId entity, NodeId keyframe) {
  const auto track = graph.tracks().find(entity);
  if (track == graph.tracks().end()) return nullptr;
  const CNodeEntity* before = nullptr;
  for (const auto& node : track->second) {
    if (node->keyframe <= keyframe) {
      before = node.get();
    } else {
      return node->moved ? nullptr : before ? before : node.get();
    }
  }
  return before;
}

/// The frames of one gap as a chain of poses.
class Chain {
 public:
  explicit Chain(std::span<const FramePose> frames) {
    for (const FramePose& frame : frames) {
      auto node = std::make_shared<CNodeKeyframe>();
      node->id = {delta_.nodes.size()};
      node->stamp = frame.stamp;
      node->T_map_node = frame.T_map_base;
      delta_.nodes.push_back(node);
    }
  }

  void hold(std::size_t i, const Pose3& T_map_base, const Matrix6& covariance,
            const RobustKernel& kernel = {}) {
    auto edge = std::make_shared<CEdgePosePrior>();
    edge->nodes = {delta_.nodes[i]->id};
    edge->T_map_node = T_map_base;
    add(edge, covariance, kernel);
  }

  void link(std::size_t i, const Pose3& T_last_base, const Matrix6& covariance) {
    auto edge = std::make_shared<CEdgeOdometry>();
    edge->nodes = {delta_.nodes[i - 1]->id, delta_.nodes[i]->id};
    edge->T_1_2 = T_last_base;
    add(edge, covariance, {});
  }

  /// Frame i keeps its velocity, but for an acceleration [m/s²].
  void steady(std::size_t i, double sigma_m_s2, const RobustKernel& kernel) {
    const auto stamp = [this](std::size_t k) {
      return static_cast<const CNodeKeyframe&>(*delta_.nodes[k]).stamp;
    };
    const double before_s = secondsBetween(stamp(i - 1), stamp(i)),
                 after_s = secondsBetween(stamp(i), stamp(i + 1));
    if (before_s <= 0.0 || after_s <= 0.0) return;
    auto edge = std::make_shared<CEdgeAgentVelocity>();
    edge->nodes = {delta_.nodes[i - 1]->id, delta_.nodes[i]->id, delta_.nodes[i + 1]->id};
    edge->dt_12_s = before_s;
    edge->dt_23_s = after_s;
    const double sigma_m_s = sigma_m_s2 * 0.5 * (before_s + after_s);
    add(edge, sigma_m_s * sigma_m_s * Matrix3::Identity(), kernel);
  }

  /// The frames [begin, end) of the solution; all as they were where there is none.
  void solve(std::size_t begin, std::size_t end, std::span<FramePose> frames) {
    CSceneGraph graph;
    graph.apply(delta_);
    if (!Optimizer(SolverParams()).optimizeFully(graph).usable()) return;
    for (std::size_t i = begin; i < end; ++i)
      frames[i].T_map_base = graph.keyframes()[i]->T_map_base();
  }

 private:
  template <class Edge>
  void add(const std::shared_ptr<Edge>& edge, const MatrixX& covariance,
           const RobustKernel& kernel) {
    edge->id = {delta_.edges.size()};
    edge->setCovariance(covariance);
    edge->kernel = kernel;
    delta_.edges.push_back(edge);
  }

  GraphDelta delta_;
};

}  // namespace

void fields(FieldVisitor& v, FrameRefinementParams& p) {
  v.flag("objects", p.objects,
         "In the end, poses of frames between keyframes also rest on the objects seen in them");
  v.number("detection_scale", p.detection_scale,
           "Factor on the standard deviations of their detections: those of successive frames err "
           "alike",
           Range::positive());
  v.optionalNumber("acceleration_sigma_m_s2", p.acceleration_sigma_m_s2,
                   "And on the robot's inertia: how much its velocity changes in a second; the "
                   "better the odometry, the less it counts",
                   Range::positive());
  v.number("kernel_width", p.kernel_width,
           "Cauchy width of detections and accelerations in standard deviations",
           Range::positive());
}

std::vector<ObjectSighting> sightingsOf(const std::vector<EntityObservation>& observations) {
  std::vector<ObjectSighting> objects;
  for (const EntityObservation& o : observations) {
    if (o.semantic_class == SemanticClass::kObject)
      objects.push_back({o.entity, o.T_base_entity, o.covariance});
  }
  return objects;
}

void refineFrames(const CSceneGraph& graph, std::size_t keyframe,
                  const std::map<NodeId, Matrix6>& entity_covariances,
                  std::span<const FrameMeasurements> measurements,
                  const FrameRefinementParams& params, std::span<FramePose> frames) {
  const bool open = keyframe + 1 == graph.keyframes().size();
  const std::size_t end = open ? frames.size() : frames.size() - 1;
  const NodeId id = graph.keyframes()[keyframe]->id;
  Chain chain(frames);
  bool informed = params.acceleration_sigma_m_s2.has_value() && frames.size() > 2;
  for (std::size_t i = 1; i < end && params.objects; ++i) {
    for (const ObjectSighting& sighting : measurements[i].objects) {
      const CNodeEntity* place = placeOf(graph, sighting.entity, id);
      if (!place) continue;
      const auto known = entity_covariances.find(place->id);
      if (known == entity_covariances.end()) continue;
      // T_map_base = T_map_entity · T_entity_base.
      const Matrix6 A = composeJacobianLeft(sighting.T_base_entity.inverse());
      const Matrix6 covariance =
          params.detection_scale * params.detection_scale * sighting.covariance + known->second;
      chain.hold(i, place->T_map_entity() * sighting.T_base_entity.inverse(),
                 A * covariance * A.transpose(), {KernelType::kCauchy, params.kernel_width});
      informed = true;
    }
  }
  if (!informed) return;
  const Matrix6 fixed = isotropicCovariance(kFixed_m, kFixed_rad);
  chain.hold(0, frames[0].T_map_base, fixed);
  if (!open) chain.hold(end, frames[end].T_map_base, fixed);
  for (std::size_t i = 1; i < frames.size(); ++i) {
    chain.link(i, frames[i - 1].T_odom_base.inverse() * frames[i].T_odom_base,
               measurements[i].step_covariance);
  }
  if (params.acceleration_sigma_m_s2) {
    for (std::size_t i = 1; i + 1 < frames.size(); ++i)
      chain.steady(i, *params.acceleration_sigma_m_s2, {KernelType::kCauchy, params.kernel_width});
  }
  chain.solve(1, end, frames);
}

}  // namespace dynemo
