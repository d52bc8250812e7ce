#include "problem.h"

namespace dynemo::backend {

Problem::Problem(const CSceneGraph& graph) {
  const auto& slots = graph.nodeSlots();
  variable_of_node_.assign(slots.size(), -1);
  state_offset_.push_back(0);
  for (std::size_t i = 0; i < slots.size(); ++i) {
    if (!slots[i] || graph.edgesOf({i}).empty()) continue;
    variable_of_node_[i] = static_cast<int>(nodes_.size());
    nodes_.push_back(slots[i].get());
    state_offset_.push_back(state_offset_.back() + static_cast<std::size_t>(slots[i]->stateSize()));
    connectivity_.tangent_size.push_back(slots[i]->tangentSize());
    tangent_size_ += static_cast<std::size_t>(slots[i]->tangentSize());
  }
  connectivity_.factor_begin.push_back(0);
  for (const auto& edge : graph.edgeSlots()) {
    if (!edge) continue;
    edges_.push_back(edge.get());
    for (const NodeId id : edge->nodes) {
      connectivity_.factor_variables.push_back(variable_of_node_[id.value]);
    }
    connectivity_.factor_begin.push_back(static_cast<int>(connectivity_.factor_variables.size()));
  }
}

std::vector<double> Problem::readStates() const {
  std::vector<double> states(stateSize());
  for (std::size_t v = 0; v < nodes_.size(); ++v) nodes_[v]->readState(&states[state_offset_[v]]);
  return states;
}

std::string describe(const CEdgeBase& edge) {
  std::string text =
      std::string(edge.kind()) + " edge " + std::to_string(edge.id.value) + " (nodes ";
  for (std::size_t i = 0; i < edge.nodes.size(); ++i) {
    text += (i ? ", " : "") + std::to_string(edge.nodes[i].value);
  }
  return text + ")";
}

std::string describe(const CNodeBase& node) {
  return std::string(node.kind()) + " node " + std::to_string(node.id.value);
}

}  // namespace dynemo::backend
