// The hierarchical scene graph: keyframes, entities, planes and floors, and the edges between them.
#pragma once

#include <mrpt/graphs/CDirectedGraph.h>

#include <iosfwd>
#include <map>
#include <memory>
#include <vector>

#include "dynemo/graph/edge.h"
#include "dynemo/graph/node_entity.h"
#include "dynemo/graph/node_floor.h"
#include "dynemo/graph/node_keyframe.h"
#include "dynemo/graph/node_plane.h"
#include "dynemo/graph/slots.h"

namespace dynemo {

/// Nodes and edges to add and to take out, prepared without touching the graph. Ids count on from
/// the graph's nextNodeId() and nextEdgeId() in the order of the lists; those of removed nodes and
/// edges are not used again.
struct GraphDelta {
  std::vector<CNodeBase::Ptr> nodes;
  std::vector<CEdgeBase::Ptr> edges;
  std::vector<EdgeId> removed_edges;
  /// All their edges must be among removed_edges.
  std::vector<NodeId> removed_nodes{};
  /// By what the areas of floors grow.
  std::vector<std::pair<NodeId, Eigen::AlignedBox2d>> floor_areas{};
  bool empty() const {
    return nodes.empty() && edges.empty() && removed_edges.empty() && removed_nodes.empty() &&
           floor_areas.empty();
  }
};

/// Layers, bottom up: keyframes with the entities seen from them; planes; floors. Edges point from
/// the node that measures to the measured one. A const graph can be read by any number of threads;
/// only apply(), setStates of the optimiser and the drift's setter change it. Topology is MRPT's
/// CDirectedGraph, so its algorithms (neighbours, Dijkstra, Graphviz) apply.
class CSceneGraph : public mrpt::serialization::CSerializable {
  DEFINE_SERIALIZABLE(CSceneGraph, dynemo)
 public:
  struct EdgeHolder {
    std::shared_ptr<CEdgeBase> edge;
  };
  using Topology = mrpt::graphs::CDirectedGraph<EdgeHolder>;

  /// Drift of the odometry: T_map_odom = T_map_base · T_odom_base⁻¹ of the newest keyframe.
  Pose3 T_map_odom;

  NodeId nextNodeId() const { return {nodes_.size()}; }
  EdgeId nextEdgeId() const { return {edges_.size()}; }

  /// Adds and removes what the delta says: first out, then in. Throws std::logic_error when ids do
  /// not continue the graph's, an edge names a node that is not there, or a node to remove has
  /// edges left.
  void apply(const GraphDelta& delta);

  std::size_t nodeCount() const { return node_count_; }
  std::size_t edgeCount() const { return edge_count_; }

  /// All nodes and edges by id. A removed one is a null pointer there, and is left out of loops.
  const Slots<CNodeBase::Ptr>& nodeSlots() const { return nodes_; }
  const Slots<CEdgeBase::Ptr>& edgeSlots() const { return edges_; }

  /// The node, or nullptr when there is none of that id and class.
  template <class Node>
  const Node* findNode(NodeId id) const {
    return id.value < nodes_.size() ? dynamic_cast<const Node*>(nodes_[id.value].get()) : nullptr;
  }
  /// The node; throws std::out_of_range when there is none of that id and class.
  template <class Node>
  const Node& getNode(NodeId id) const {
    if (const Node* node = findNode<Node>(id)) return *node;
    throw std::out_of_range("no such node in the scene graph: " + std::to_string(id.value));
  }

  /// Keyframes in the order of their creation.
  const std::vector<std::shared_ptr<CNodeKeyframe>>& keyframes() const { return keyframes_; }
  const std::vector<std::shared_ptr<CNodePlane>>& planes() const { return planes_; }
  const std::vector<std::shared_ptr<CNodeFloor>>& floors() const { return floors_; }
  /// Observations of each entity in the order of their creation.
  const std::map<EntityId, std::vector<std::shared_ptr<CNodeEntity>>>& tracks() const {
    return tracks_;
  }
  /// The latest observation of an entity, or nullptr.
  const CNodeEntity* lastObservation(EntityId entity) const;

  /// Edges that name the node, ascending by id.
  const std::vector<EdgeId>& edgesOf(NodeId node) const;

  const Topology& topology() const { return topology_; }

  /// eᵀΩe of one edge at the current estimates.
  double squaredError(const CEdgeBase& edge) const;
  /// Cost ½ Σ ρ(eᵀΩe) of one edge at the current estimates.
  double edgeCost(const CEdgeBase& edge) const;
  double totalCost() const;

  /// Gives a keyframe its scan back; for sessions. Throws std::out_of_range when there is no such
  /// keyframe.
  void setScan(NodeId keyframe, std::shared_ptr<const Scan> scan);
  /// Replaces a node's estimate; for optimisers.
  void setState(NodeId node, const double* state) { nodes_.at(node.value)->writeState(state); }

 private:
  void insertNode(const CNodeBase::Ptr& node);
  void insertEdge(const CEdgeBase::Ptr& edge);
  void removeEdge(EdgeId id);
  void removeNode(NodeId id);
  void readFrom(mrpt::serialization::CArchive& in);

  Slots<CNodeBase::Ptr> nodes_;
  Slots<CEdgeBase::Ptr> edges_;
  Slots<std::vector<EdgeId>> edges_of_node_;
  std::size_t node_count_ = 0, edge_count_ = 0;
  std::vector<std::shared_ptr<CNodeKeyframe>> keyframes_;
  std::vector<std::shared_ptr<CNodePlane>> planes_;
  std::vector<std::shared_ptr<CNodeFloor>> floors_;
  std::map<EntityId, std::vector<std::shared_ptr<CNodeEntity>>> tracks_;
  Topology topology_;
};

}  // namespace dynemo
