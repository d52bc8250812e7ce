#include "dynemo/life/keyframe_trail.h"

#include <algorithm>
#include <set>
#include <stdexcept>

namespace dynemo {
namespace {

/// A radian of heading is as far as this.
constexpr double kRadian_m = 2.0;
/// A keyframe that came later is as far as this: it is likelier to leave itself.
constexpr double kLater_m = 4.0;

/// Their errors are largely their own: the mean of many is nearer to the truth than few are.
constexpr std::size_t kHooks = 8;

/// Those that are likeliest to see the same: near, on the same floor, looking the same way.
std::vector<const CNodeKeyframe*> nearestTo(const CNodeKeyframe& keyframe,
                                            const std::vector<const CNodeKeyframe*>& staying) {
  std::vector<std::pair<std::pair<bool, double>, const CNodeKeyframe*>> all;
  for (const CNodeKeyframe* other : staying) {
    const Pose3 T = keyframe.T_map_base().inverse() * other->T_map_base();
    const double later_m = other->id > keyframe.id ? kLater_m : 0.0;
    all.push_back(
        {{other->floor != keyframe.floor, T.t.norm() + kRadian_m * rotationAngle(T) + later_m},
         other});
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<const CNodeKeyframe*> nearest;
  for (std::size_t i = 0; i < std::min(kHooks, all.size()); ++i) nearest.push_back(all[i].second);
  return nearest;
}

}  // namespace

void KeyframeTrail::add(const CNodeKeyframe& keyframe) {
  entries_.push_back({keyframe.id, keyframe.stamp, keyframe.T_odom_base, std::nullopt, {}});
}

std::size_t KeyframeTrail::indexOf(NodeId keyframe) const {
  const auto it = std::lower_bound(entries_.begin(), entries_.end(), keyframe,
                                   [](const Entry& e, NodeId id) { return e.id < id; });
  if (it == entries_.end() || it->id != keyframe)
    throw std::out_of_range("no such keyframe in the trail: " + std::to_string(keyframe.value));
  return static_cast<std::size_t>(it - entries_.begin());
}

void KeyframeTrail::hang(std::span<const NodeId> leaving, const CSceneGraph& graph) {
  const std::set<NodeId> gone(leaving.begin(), leaving.end());
  std::vector<const CNodeKeyframe*> staying;
  for (const auto& keyframe : graph.keyframes())
    if (!gone.contains(keyframe->id)) staying.push_back(keyframe.get());
  if (staying.empty()) throw std::logic_error("the last keyframe of a graph must stay");
  for (const NodeId id : leaving) {
    Entry& entry = entries_[indexOf(id)];
    const auto& node = graph.getNode<CNodeKeyframe>(id);
    entry.T_map_base = node.T_map_base();
    for (const CNodeKeyframe* hook : nearestTo(node, staying))
      entry.hooks.push_back({indexOf(hook->id), hook->T_map_base()});
    ++left_;
  }
}

Pose3 KeyframeTrail::byFirstHooks(std::size_t index, const CSceneGraph& graph) const {
  Pose3 T_here_base;
  while (entries_[index].T_map_base) {
    const Hook& hook = entries_[index].hooks.front();
    T_here_base = hook.T_map_base.inverse() * *entries_[index].T_map_base * T_here_base;
    index = hook.entry;
  }
  return graph.getNode<CNodeKeyframe>(entries_[index].id).T_map_base() * T_here_base;
}

Pose3 KeyframeTrail::T_map_base(std::size_t index, const CSceneGraph& graph) const {
  const Entry& entry = entries_[index];
  if (!entry.T_map_base) return graph.getNode<CNodeKeyframe>(entry.id).T_map_base();
  const auto carriedBy = [&](const Hook& hook) {
    return byFirstHooks(hook.entry, graph) * (hook.T_map_base.inverse() * *entry.T_map_base);
  };
  const Pose3 T_first = carriedBy(entry.hooks.front());
  Vector6 sum = Vector6::Zero();
  for (std::size_t i = 1; i < entry.hooks.size(); ++i)
    sum += local(T_first, carriedBy(entry.hooks[i]));
  return T_first.retract(sum / static_cast<double>(entry.hooks.size()));
}

}  // namespace dynemo
