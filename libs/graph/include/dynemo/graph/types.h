// The registry of node and edge classes. A new one is one file and one line in register.cpp:
// serialisation, conformance tests and exporters then find it here.
#pragma once

#include <functional>
#include <random>
#include <string>
#include <vector>

#include "dynemo/graph/edge.h"
#include "dynemo/graph/node.h"

namespace dynemo {

struct NodeType {
  std::string kind;
  /// A node with a random state.
  std::function<CNodeBase::Ptr(std::mt19937_64&)> example;
};

struct EdgeType {
  std::string kind;
  /// Kinds of the nodes it connects, in order.
  std::vector<std::string> node_kinds;
  /// Colour in pictures and scenes, 0xRRGGBB.
  std::uint32_t color_rgb;
  /// An edge with a random measurement and information, not yet connected.
  std::function<CEdgeBase::Ptr(std::mt19937_64&)> example;
};

const std::vector<NodeType>& nodeTypes();
const std::vector<EdgeType>& edgeTypes();
/// Throws std::out_of_range for an unknown kind.
const EdgeType& edgeType(const std::string& kind);

/// Makes the classes known to MRPT's serialisation. Call before reading a graph; calling again is
/// harmless.
void registerGraphClasses();

}  // namespace dynemo
