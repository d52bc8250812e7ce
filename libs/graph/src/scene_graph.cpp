#include "dynemo/graph/scene_graph.h"

#include <mrpt/serialization/CArchive.h>

#include <algorithm>
#include <stdexcept>

#include "archive.h"
#include "dynemo/graph/types.h"

using mrpt::serialization::CArchive;

IMPLEMENTS_SERIALIZABLE(CSceneGraph, CSerializable, dynemo)

namespace dynemo {
namespace {

int stateSizeOfKind(const std::string& kind) {
  static const std::map<std::string, int> sizes = [] {
    std::map<std::string, int> by_kind;
    std::mt19937_64 rng;
    for (const NodeType& type : nodeTypes()) by_kind[type.kind] = type.example(rng)->stateSize();
    return by_kind;
  }();
  return sizes.at(kind);
}

/// An edge reads its nodes' states without a check of its own: their number and sizes must be those
/// of its kind.
bool fitsNodes(const CEdgeBase& edge, const Slots<CNodeBase::Ptr>& nodes) {
  const std::vector<std::string>& kinds = edgeType(edge.kind()).node_kinds;
  if (kinds.size() != edge.nodes.size()) return false;
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    if (nodes[edge.nodes[i].value]->stateSize() != stateSizeOfKind(kinds[i])) return false;
  }
  return true;
}

}  // namespace

void CSceneGraph::apply(const GraphDelta& delta) {
  for (const EdgeId id : delta.removed_edges) removeEdge(id);
  for (const NodeId id : delta.removed_nodes) removeNode(id);
  for (const auto& node : delta.nodes) insertNode(node);
  for (const auto& edge : delta.edges) insertEdge(edge);
  for (const auto& [id, area] : delta.floor_areas) {
    const auto floor = std::dynamic_pointer_cast<CNodeFloor>(nodes_.at(id.value));
    if (!floor) throw std::logic_error("an area is given to a node that is no floor");
    floor->extendArea(area);
  }
}

void CSceneGraph::insertNode(const CNodeBase::Ptr& node) {
  if (node->id != nextNodeId()) throw std::logic_error("a new node's id must continue the graph's");
  nodes_.push_back(node);
  edges_of_node_.push_back({});
  ++node_count_;
  if (auto keyframe = std::dynamic_pointer_cast<CNodeKeyframe>(node)) {
    keyframes_.push_back(std::move(keyframe));
  } else if (auto plane = std::dynamic_pointer_cast<CNodePlane>(node)) {
    planes_.push_back(std::move(plane));
  } else if (auto floor = std::dynamic_pointer_cast<CNodeFloor>(node)) {
    floors_.push_back(std::move(floor));
  } else if (auto entity = std::dynamic_pointer_cast<CNodeEntity>(node)) {
    auto& track = tracks_[entity->entity];
    track.push_back(std::move(entity));
  }
}

void CSceneGraph::insertEdge(const CEdgeBase::Ptr& edge) {
  if (edge->id != nextEdgeId()) throw std::logic_error("a new edge's id must continue the graph's");
  if (edge->nodes.empty()) throw std::logic_error("an edge without nodes");
  for (const NodeId node : edge->nodes) {
    if (node.value >= nodes_.size() || !nodes_[node.value]) {
      throw std::logic_error(std::string(edge->kind()) +
                             " edge names a node that is not in the graph");
    }
  }
  if (!fitsNodes(*edge, nodes_)) {
    throw std::logic_error(std::string(edge->kind()) +
                           " edge connects nodes of the wrong number or kind");
  }
  if (edge->information().rows() != edge->residualSize()) {
    throw std::logic_error(std::string(edge->kind()) + " edge has no information matrix");
  }
  edges_.push_back(edge);
  ++edge_count_;
  for (const NodeId node : edge->nodes) edges_of_node_.present(node.value).push_back(edge->id);
  topology_.insertEdge(edge->nodes.front().value, edge->nodes.back().value,
                       Topology::edge_t(EdgeHolder{edge}));
}

void CSceneGraph::removeEdge(EdgeId id) {
  const auto edge = id.value < edges_.size() ? edges_[id.value] : nullptr;
  if (!edge) throw std::logic_error("an edge to remove is not in the graph");
  for (const NodeId node : edge->nodes) std::erase(edges_of_node_.present(node.value), id);
  const auto [first, last] = topology_.edges.equal_range(
      mrpt::graphs::TPairNodeIDs(edge->nodes.front().value, edge->nodes.back().value));
  for (auto it = first; it != last; ++it) {
    if (it->second.edge != edge) continue;
    topology_.edges.erase(it);
    break;
  }
  edges_.remove(id.value);
  --edge_count_;
}

void CSceneGraph::removeNode(NodeId id) {
  const auto node = id.value < nodes_.size() ? nodes_[id.value] : nullptr;
  if (!node) throw std::logic_error("a node to remove is not in the graph");
  if (!edges_of_node_[id.value].empty()) {
    throw std::logic_error(std::string(node->kind()) + " node to remove still has edges");
  }
  const auto eraseFrom = [&](auto& list) {
    std::erase_if(list, [&](const auto& other) { return other->id == id; });
  };
  eraseFrom(keyframes_);
  eraseFrom(planes_);
  eraseFrom(floors_);
  for (auto& [entity, track] : tracks_) eraseFrom(track);
  std::erase_if(tracks_, [](const auto& track) { return track.second.empty(); });
  nodes_.remove(id.value);
  edges_of_node_.remove(id.value);
  --node_count_;
}

const CNodeEntity* CSceneGraph::lastObservation(EntityId entity) const {
  const auto it = tracks_.find(entity);
  return it == tracks_.end() || it->second.empty() ? nullptr : it->second.back().get();
}

void CSceneGraph::setScan(NodeId keyframe, std::shared_ptr<const Scan> scan) {
  for (const auto& node : keyframes_) {
    if (node->id == keyframe) {
      node->scan = std::move(scan);
      return;
    }
  }
  throw std::out_of_range("no such keyframe in the scene graph: " + std::to_string(keyframe.value));
}

const std::vector<EdgeId>& CSceneGraph::edgesOf(NodeId node) const {
  return edges_of_node_.at(node.value);
}

double CSceneGraph::squaredError(const CEdgeBase& edge) const {
  std::array<std::array<double, 16>, kMaxEdgeNodes> states;
  std::array<const double*, kMaxEdgeNodes> pointers{};
  for (std::size_t i = 0; i < edge.nodes.size(); ++i) {
    nodes_.at(edge.nodes[i].value)->readState(states[i].data());
    pointers[i] = states[i].data();
  }
  Residual e;
  edge.evaluate(std::span(pointers.data(), edge.nodes.size()), e, nullptr);
  return (edge.sqrtInformation() * e).squaredNorm();
}

double CSceneGraph::edgeCost(const CEdgeBase& edge) const {
  return 0.5 * edge.kernel(squaredError(edge)).rho;
}

double CSceneGraph::totalCost() const {
  double cost = 0.0;
  for (const auto& edge : edges_) cost += edgeCost(*edge);
  return cost;
}

std::uint8_t CSceneGraph::serializeGetVersion() const { return 0; }

void CSceneGraph::serializeTo(CArchive& out) const {
  put(out, T_map_odom);
  const auto write = [&out](const auto& slots) {
    out.WriteAs<std::uint32_t>(slots.size());
    for (std::size_t i = 0; i < slots.size(); ++i) {
      out << static_cast<bool>(slots[i]);
      if (slots[i]) out << *slots[i];
    }
  };
  write(nodes_);
  write(edges_);
}

void CSceneGraph::serializeFrom(CArchive& in, std::uint8_t version) {
  if (version != 0) MRPT_THROW_UNKNOWN_SERIALIZATION_VERSION(version);
  *this = CSceneGraph();
  try {
    readFrom(in);
  } catch (const std::logic_error& e) {
    // What is a mistake of the caller in apply() is damaged data here.
    throw DataError(std::string("a stored graph is not consistent: ") + e.what());
  }
}

void CSceneGraph::readFrom(CArchive& in) {
  get(in, T_map_odom);
  const auto read = [&in](auto insert, auto skip) {
    const std::uint32_t n = getLength(in, 1'000'000'000);
    for (std::uint32_t i = 0; i < n; ++i) {
      if (getBool(in)) {
        insert(in.ReadObject());
      } else {
        skip();
      }
    }
  };
  read(
      [this](const auto& object) {
        auto node = std::dynamic_pointer_cast<CNodeBase>(object);
        if (!node) throw DataError("a stored node is not a node");
        insertNode(node);
      },
      [this] {
        nodes_.skip();
        edges_of_node_.skip();
      });
  read(
      [this](const auto& object) {
        auto edge = std::dynamic_pointer_cast<CEdgeBase>(object);
        if (!edge) throw DataError("a stored edge is not an edge");
        insertEdge(edge);
      },
      [this] { edges_.skip(); });
}

}  // namespace dynemo
