#include "frame_tree.h"

#include <algorithm>

namespace dynemo {
namespace {

/// Rounding in the messages of a transform that stands still.
constexpr double kStill = 1e-6;

}  // namespace

void FrameTree::add(const std::string& parent, const std::string& child,
                    const Pose3& T_parent_child) {
  if (parent == child || !T_parent_child.isFinite()) return;
  frames_.insert(parent);
  frames_.insert(child);
  const auto [it, is_new] = links_.try_emplace(child, Link{parent, T_parent_child});
  Link& link = it->second;
  if (!is_new &&
      (link.parent != parent || local(link.T_parent_child, T_parent_child).norm() > kStill))
    link.changes = true;
}

bool FrameTree::knows(const std::string& frame) const { return frames_.contains(frame); }

std::vector<const FrameTree::Link*> FrameTree::up(const std::string& frame) const {
  std::vector<const Link*> chain;
  std::string at = frame;
  for (auto it = links_.find(at); it != links_.end() && chain.size() < links_.size();
       it = links_.find(at)) {
    chain.push_back(&it->second);
    at = it->second.parent;
  }
  return chain;
}

std::optional<Pose3> FrameTree::find(const std::string& a, const std::string& b) const {
  if (a == b) return Pose3();
  auto from_a = up(a), from_b = up(b);
  const std::string root_a = from_a.empty() ? a : from_a.back()->parent;
  const std::string root_b = from_b.empty() ? b : from_b.back()->parent;
  if (root_a != root_b) return std::nullopt;
  // What both have in common above drops out, so that it need not stand still.
  while (!from_a.empty() && !from_b.empty() && from_a.back() == from_b.back()) {
    from_a.pop_back();
    from_b.pop_back();
  }
  Pose3 T_common_a, T_common_b;
  for (const Link* link : from_a) T_common_a = link->T_parent_child * T_common_a;
  for (const Link* link : from_b) T_common_b = link->T_parent_child * T_common_b;
  return (T_common_a.inverse() * T_common_b).normalized();
}

bool FrameTree::changes(const std::string& a, const std::string& b) const {
  auto from_a = up(a), from_b = up(b);
  while (!from_a.empty() && !from_b.empty() && from_a.back() == from_b.back()) {
    from_a.pop_back();
    from_b.pop_back();
  }
  const auto moving = [](const Link* link) { return link->changes; };
  return std::any_of(from_a.begin(), from_a.end(), moving) ||
         std::any_of(from_b.begin(), from_b.end(), moving);
}

}  // namespace dynemo
