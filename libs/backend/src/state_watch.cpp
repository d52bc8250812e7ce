#include "state_watch.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace dynemo::backend {
namespace {

/// Nodes whose state is fetched from memory before its turn, and where in a node it lies.
constexpr std::size_t kAhead = 8;
constexpr int kStateBytes = 128, kCacheLine = 64;

void prefetch(const CNodeBase* node) {
  for (int at = 0; at < kStateBytes; at += kCacheLine)
    __builtin_prefetch(reinterpret_cast<const char*>(node) + at);
}

}  // namespace

void StateWatch::compact(const CSceneGraph& graph) {
  std::size_t end = 0;
  for (std::size_t i = 0; i + 1 < offset_.size(); ++i) {
    const std::size_t begin = std::exchange(offset_[i], end);
    if (i >= graph.nodeSlots().size() || !graph.nodeSlots()[i]) continue;
    for (std::size_t k = begin; k < offset_[i + 1]; ++k) states_[end++] = states_[k];
  }
  offset_.back() = end;
  states_.resize(end);
  gone_ = 0;
}

std::span<const NodeId> StateWatch::moved(const CSceneGraph& graph) {
  if (2 * gone_ > states_.size()) compact(graph);
  gone_ = 0;
  moved_.clear();
  const auto& slots = graph.nodeSlots();
  for (std::size_t i = 0; i < slots.size(); ++i) {
    if (i + kAhead < slots.size()) prefetch(slots[i + kAhead].get());
    const std::size_t size = slots[i] ? static_cast<std::size_t>(slots[i]->stateSize()) : 0;
    const bool known = i + 1 < offset_.size();
    if (!known) {
      offset_.push_back(offset_.back() + size);
      states_.resize(offset_.back());
    }
    if (size == 0) gone_ += offset_[i + 1] - offset_[i];
    // A removed node keeps its place for a while; another kind of node in its slot belongs to
    // another graph.
    if (size == 0 || size != offset_[i + 1] - offset_[i]) continue;
    double* const seen = &states_[offset_[i]];
    if (!known) {
      slots[i]->readState(seen);
      continue;
    }
    read_.resize(size);
    slots[i]->readState(read_.data());
    // Bytes: a state that is not a number equals itself.
    if (std::memcmp(read_.data(), seen, size * sizeof(double)) == 0) continue;
    std::copy(read_.begin(), read_.end(), seen);
    moved_.push_back({i});
  }
  return moved_;
}

void StateWatch::record(const CNodeBase& node) {
  const std::size_t i = node.id.value;
  if (i + 1 < offset_.size() && offset_[i + 1] > offset_[i]) node.readState(&states_[offset_[i]]);
}

}  // namespace dynemo::backend
