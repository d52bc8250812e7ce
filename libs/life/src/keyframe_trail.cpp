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

KeyframeTrail::Hook::Hook(std::size_t other, const Pose3& T_other_this)
    : entry(static_cast<std::uint32_t>(other)) {
  Eigen::Map<Eigen::Vector3f>(t_m.data()) = T_other_this.t.cast<float>();
  Eigen::Map<Eigen::Vector4f>(q_xyzw.data()) = T_other_this.quaternion().coeffs().cast<float>();
}

Pose3 KeyframeTrail::Hook::T_other_this() const {
  const Eigen::Vector4d q = Eigen::Map<const Eigen::Vector4f>(q_xyzw.data()).cast<double>();
  return {Eigen::Quaterniond(q), Eigen::Map<const Eigen::Vector3f>(t_m.data()).cast<double>()};
}

void KeyframeTrail::add(const CNodeKeyframe& keyframe) {
  entries_.push_back({keyframe.id, keyframe.stamp, keyframe.T_odom_base});
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
    entry.first_hook = static_cast<std::uint32_t>(hooks_.size());
    for (const CNodeKeyframe* other : nearestTo(node, staying)) {
      hooks_.emplace_back(indexOf(other->id), other->T_map_base().inverse() * node.T_map_base());
      ++entry.hooks;
    }
    ++left_;
  }
}

Pose3 KeyframeTrail::byFirstHooks(std::size_t index, const CSceneGraph& graph) const {
  Pose3 T_here_base;
  while (entries_[index].hooks > 0) {
    const Hook& hook = hooks_[entries_[index].first_hook];
    T_here_base = hook.T_other_this() * T_here_base;
    index = hook.entry;
  }
  return graph.getNode<CNodeKeyframe>(entries_[index].id).T_map_base() * T_here_base;
}

Pose3 KeyframeTrail::T_map_base(std::size_t index, const CSceneGraph& graph) const {
  const Entry& entry = entries_[index];
  if (entry.hooks == 0) return graph.getNode<CNodeKeyframe>(entry.id).T_map_base();
  const auto carriedBy = [&](std::uint32_t i) {
    const Hook& hook = hooks_[entry.first_hook + i];
    return byFirstHooks(hook.entry, graph) * hook.T_other_this();
  };
  const Pose3 T_first = carriedBy(0);
  Vector6 sum = Vector6::Zero();
  for (std::uint32_t i = 1; i < entry.hooks; ++i) sum += local(T_first, carriedBy(i));
  return T_first.retract(sum / static_cast<double>(entry.hooks));
}

}  // namespace dynemo
