#include <mrpt/rtti/CObject.h>

#include <stdexcept>

#include "dynemo/graph/edge_agent_motion.h"
#include "dynemo/graph/edge_floor_entity.h"
#include "dynemo/graph/edge_plane.h"
#include "dynemo/graph/edge_prior.h"
#include "dynemo/graph/edge_relative_pose.h"
#include "dynemo/graph/edge_summary.h"
#include "dynemo/graph/scene_graph.h"
#include "dynemo/graph/types.h"

namespace dynemo {
namespace {

template <class Node>
NodeType nodeType() {
  return {Node().kind(), [](std::mt19937_64& rng) -> CNodeBase::Ptr {
            if constexpr (requires { Node::example(rng); }) return Node::example(rng);
            auto node = std::make_shared<Node>();
            if constexpr (std::is_base_of_v<CNodePose, Node>) {
              node->T_map_node = randomPose(rng);
              node->T_map_node_first = randomPose(rng);
            } else {
              std::vector<double> zero(static_cast<std::size_t>(node->stateSize()), 0.0), delta(6);
              for (double& d : delta) d = static_cast<double>(rng() >> 11) * 0x1.0p-53;
              node->readState(zero.data());
              node->retract(zero.data(), delta.data(), zero.data());
              node->writeState(zero.data());
            }
            return node;
          }};
}

template <class Edge>
EdgeType edgeTypeOf(std::vector<std::string> node_kinds, std::uint32_t color_rgb) {
  return {Edge().kind(), std::move(node_kinds), color_rgb,
          [](std::mt19937_64& rng) -> CEdgeBase::Ptr { return Edge::example(rng); }};
}

}  // namespace

const std::vector<NodeType>& nodeTypes() {
  static const std::vector<NodeType> types = {
      nodeType<CNodeKeyframe>(),
      nodeType<CNodeEntity>(),
      nodeType<CNodePlane>(),
      nodeType<CNodeFloor>(),
  };
  return types;
}

const std::vector<EdgeType>& edgeTypes() {
  static const std::vector<EdgeType> types = {
      edgeTypeOf<CEdgePosePrior>({"keyframe"}, 0x808080),
      edgeTypeOf<CEdgeFloorPrior>({"floor"}, 0x808080),
      edgeTypeOf<CEdgeOdometry>({"keyframe", "keyframe"}, 0x2ca02c),
      edgeTypeOf<CEdgeKeyframeEntity>({"keyframe", "entity"}, 0xff7f0e),
      edgeTypeOf<CEdgeIntraEntity>({"entity", "entity"}, 0xd62728),
      edgeTypeOf<CEdgeAgentLine>({"entity", "entity"}, 0xe377c2),
      edgeTypeOf<CEdgeAgentVelocity>({"entity", "entity", "entity"}, 0x9467bd),
      edgeTypeOf<CEdgeFloorEntity>({"floor", "entity"}, 0x1f77b4),
      edgeTypeOf<CEdgeKeyframePlane>({"keyframe", "plane"}, 0xbcbd22),
      edgeTypeOf<CEdgeFloorGround>({"keyframe", "floor"}, 0xaec7e8),
      edgeTypeOf<CEdgePlaneParallel>({"plane", "plane"}, 0x8c564b),
      edgeTypeOf<CEdgePlanePerpendicular>({"plane", "plane"}, 0xc49c94),
      edgeTypeOf<CEdgeLoopClosure>({"keyframe", "keyframe"}, 0x17becf),
      edgeTypeOf<CEdgeSummary>({"keyframe", "keyframe"}, 0xc7c7c7),
  };
  return types;
}

const EdgeType& edgeType(const std::string& kind) {
  for (const EdgeType& type : edgeTypes()) {
    if (type.kind == kind) return type;
  }
  throw std::out_of_range("unknown edge kind: " + kind);
}

void registerGraphClasses() {
  using mrpt::rtti::registerClass;
  registerClass(CLASS_ID(CNodeKeyframe));
  registerClass(CLASS_ID(CNodeEntity));
  registerClass(CLASS_ID(CNodePlane));
  registerClass(CLASS_ID(CNodeFloor));
  registerClass(CLASS_ID(CEdgePosePrior));
  registerClass(CLASS_ID(CEdgeFloorPrior));
  registerClass(CLASS_ID(CEdgeOdometry));
  registerClass(CLASS_ID(CEdgeKeyframeEntity));
  registerClass(CLASS_ID(CEdgeIntraEntity));
  registerClass(CLASS_ID(CEdgeAgentLine));
  registerClass(CLASS_ID(CEdgeAgentVelocity));
  registerClass(CLASS_ID(CEdgeFloorEntity));
  registerClass(CLASS_ID(CEdgeKeyframePlane));
  registerClass(CLASS_ID(CEdgeFloorGround));
  registerClass(CLASS_ID(CEdgePlaneParallel));
  registerClass(CLASS_ID(CEdgePlanePerpendicular));
  registerClass(CLASS_ID(CEdgeLoopClosure));
  registerClass(CLASS_ID(CEdgeSummary));
  registerClass(CLASS_ID(CSceneGraph));
}

}  // namespace dynemo
