// The least-squares problem of a scene graph as flat arrays: what the solver reads instead of the
// graph.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "dynemo/graph/scene_graph.h"

namespace dynemo::backend {

/// Which variables exist and which of them each factor connects: all that the sparsity of the
/// problem depends on.
struct Connectivity {
  /// Tangent size of each variable.
  std::vector<int> tangent_size;
  /// Variables of factor f: factor_variables[factor_begin[f] … factor_begin[f + 1]).
  std::vector<int> factor_begin, factor_variables;

  int variables() const { return static_cast<int>(tangent_size.size()); }
  int factors() const { return static_cast<int>(factor_begin.size()) - 1; }
  std::span<const int> variablesOf(int factor) const {
    return std::span(factor_variables)
        .subspan(static_cast<std::size_t>(factor_begin[factor]),
                 static_cast<std::size_t>(factor_begin[factor + 1] - factor_begin[factor]));
  }
  bool operator==(const Connectivity&) const = default;
};

/// "odometry edge 12 (nodes 3, 4)" and "keyframe node 3", for messages.
std::string describe(const CEdgeBase& edge);
std::string describe(const CNodeBase& node);

/// Variables are the graph's nodes that have an edge, ascending by id; factors its edges, ascending
/// by id. Holds pointers into the graph: valid until the graph changes.
class Problem {
 public:
  explicit Problem(const CSceneGraph& graph);

  const Connectivity& connectivity() const { return connectivity_; }
  const CNodeBase& node(int variable) const { return *nodes_[variable]; }
  const CEdgeBase& edge(int factor) const { return *edges_[factor]; }
  std::size_t tangentSize() const { return tangent_size_; }
  std::size_t stateSize() const { return state_offset_.back(); }
  std::size_t stateOffset(int variable) const { return state_offset_[variable]; }
  /// The variable of a node, or −1 when the node is not part of the problem.
  int variableOf(NodeId node) const {
    return node.value < variable_of_node_.size() ? variable_of_node_[node.value] : -1;
  }

  /// All states, one behind the other, from the graph's estimates.
  std::vector<double> readStates() const;

  std::string describeFactor(int factor) const { return describe(edge(factor)); }
  std::string describeVariable(int variable) const { return describe(node(variable)); }

 private:
  Connectivity connectivity_;
  std::vector<const CNodeBase*> nodes_;
  std::vector<const CEdgeBase*> edges_;
  std::vector<std::size_t> state_offset_;
  std::vector<int> variable_of_node_;
  std::size_t tangent_size_ = 0;
};

}  // namespace dynemo::backend
