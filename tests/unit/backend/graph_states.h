// All estimates of a graph in one vector, and back.
#pragma once

#include <vector>

#include "dynemo/graph/scene_graph.h"

namespace dynemo::test {

inline std::vector<double> statesOf(const CSceneGraph& graph) {
  std::vector<double> all;
  for (const auto& node : graph.nodeSlots()) {
    if (!node) continue;
    std::vector<double> state(static_cast<std::size_t>(node->stateSize()));
    node->readState(state.data());
    all.insert(all.end(), state.begin(), state.end());
  }
  return all;
}

inline void restoreStates(CSceneGraph& graph, const std::vector<double>& states) {
  const double* state = states.data();
  for (const auto& node : graph.nodeSlots()) {
    if (!node) continue;
    graph.setState(node->id, state);
    state += node->stateSize();
  }
}

}  // namespace dynemo::test
