// Notices estimates that somebody else has changed.
#pragma once

#include <span>
#include <vector>

#include "dynemo/graph/scene_graph.h"

namespace dynemo::backend {

/// Remembers the state of every node as it was last seen or written.
class StateWatch {
 public:
  /// Nodes that were seen before and whose state is another one now, ascending. The states of all
  /// nodes count as seen from here on.
  std::span<const NodeId> moved(const CSceneGraph& graph);
  /// The state of the node was written on purpose.
  void record(const CNodeBase& node);

 private:
  void compact(const CSceneGraph& graph);

  std::vector<std::size_t> offset_ = {0};  ///< by node id; a slot without a state is empty
  std::vector<double> states_, read_;
  std::size_t gone_ = 0;  ///< of states_, of removed nodes
  std::vector<NodeId> moved_;
};

}  // namespace dynemo::backend
