// Examples of every registered class, and the means to name test cases after them.
#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "dynemo/graph/types.h"

namespace dynemo::test {

struct KindName {
  template <class Info>
  std::string operator()(const Info& info) const {
    return info.param.kind;
  }
};

inline const NodeType& nodeTypeOf(const std::string& kind) {
  for (const NodeType& type : nodeTypes()) {
    if (type.kind == kind) return type;
  }
  throw std::out_of_range("unknown node kind: " + kind);
}

/// Random nodes that an edge of this kind can connect.
inline std::vector<CNodeBase::Ptr> examplesFor(const EdgeType& type, std::mt19937_64& rng) {
  std::vector<CNodeBase::Ptr> nodes;
  for (const std::string& kind : type.node_kinds) nodes.push_back(nodeTypeOf(kind).example(rng));
  return nodes;
}

/// States of nodes in the layout that edges read.
class States {
 public:
  explicit States(const std::vector<CNodeBase::Ptr>& nodes) {
    for (const auto& node : nodes) {
      values_.emplace_back(static_cast<std::size_t>(node->stateSize()));
      node->readState(values_.back().data());
    }
    for (const auto& v : values_) pointers_.push_back(v.data());
  }
  States(const States&) = delete;
  States& operator=(const States&) = delete;

  double* of(std::size_t node) { return values_[node].data(); }
  std::span<const double* const> pointers() const { return pointers_; }

 private:
  std::vector<std::vector<double>> values_;
  std::vector<const double*> pointers_;
};

inline Residual residualAt(const CEdgeBase& edge, const States& states) {
  Residual e;
  edge.evaluate(states.pointers(), e, nullptr);
  return e;
}

}  // namespace dynemo::test
