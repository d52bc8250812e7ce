#include "rooms.h"

#include "dynemo/core/noise.h"

namespace dynemo::test {
namespace {

constexpr double kHalfBox_m = 0.25;
constexpr double kWall_m = 6.0;

bool onBox(const Vector3& p, const Vector3& center) {
  return ((p - center).cwiseAbs().array() <= kHalfBox_m + 1e-3).all();
}

/// Where the ray from the origin along (1, y, z) ends: at the front of a box or at the wall.
Vector3 rayEnd(double y, double z, const std::vector<Vector3>& boxes) {
  const Vector3 direction(1.0, y, z);
  double x = kWall_m;
  for (const Vector3& center : boxes) {
    const double front_x = center.x() - kHalfBox_m;
    if (front_x < x && onBox(front_x * direction, center)) x = front_x;
  }
  return x * direction;
}

}  // namespace

NodeId SessionBuilder::keyframe(double seconds, const Pose3& T_world_base) {
  auto node = std::make_shared<CNodeKeyframe>();
  node->id = session.graph.nextNodeId();
  node->stamp = at(seconds);
  node->T_map_node = node->T_odom_base = T_map_world_ * T_world_base;
  session.graph.apply(GraphDelta{{node}, {}, {}});
  return node->id;
}

NodeId SessionBuilder::scan(double seconds, const std::vector<Vector3>& boxes_world) {
  const NodeId id = keyframe(seconds);
  auto scan = std::make_shared<Scan>();
  for (double y = -0.6; y <= 0.6; y += 0.02) {
    for (double z = -0.3; z <= 0.3; z += 0.02) {
      scan->cloud.points.push_back(rayEnd(y, z, boxes_world).cast<float>());
    }
  }
  session.graph.setScan(id, scan);
  return id;
}

void SessionBuilder::see(std::int64_t entity, double seconds, const Pose3& T_world_entity,
                         bool moved, SemanticClass semantic_class, const std::string& name) {
  auto node = std::make_shared<CNodeEntity>();
  node->id = session.graph.nextNodeId();
  node->entity = {entity};
  node->name = name;
  node->semantic_class = semantic_class;
  node->stamp = at(seconds);
  node->T_map_node = T_map_world_ * T_world_entity;
  node->moved = moved;
  if (!session.graph.keyframes().empty()) {
    const CNodeKeyframe& keyframe = *session.graph.keyframes().back();
    node->keyframe = keyframe.id;
    for (std::uint32_t i = 0; keyframe.scan && i < keyframe.scan->cloud.size(); ++i) {
      const Vector3 p_world = keyframe.scan->cloud.points[i].cast<double>();
      if (onBox(p_world, T_world_entity.t)) node->fragment.push_back(i);
    }
  }
  session.entity_covariances[node->id] = isotropicCovariance(0.01, 0.02);
  session.graph.apply(GraphDelta{{node}, {}, {}});
}

}  // namespace dynemo::test
