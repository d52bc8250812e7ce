#include "dynemo/life/keyframe_retention.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <tuple>

namespace dynemo {
namespace {

using Keyframes = std::vector<std::shared_ptr<CNodeKeyframe>>;

/// A square of a floor and a heading. Without a floor, heights are squares of their own.
using Cell = std::tuple<std::int64_t, long, long, long, long>;

Cell cellOf(const CNodeKeyframe& keyframe, const LifeParams& params) {
  const Pose3& T = keyframe.T_map_base();
  const auto square = [&](double x_m) { return std::lround(std::floor(x_m / params.cell_m)); };
  const double turn = std::atan2(T.R(1, 0), T.R(0, 0)) / (2.0 * std::numbers::pi) + 0.5;
  const long heading = std::lround(std::floor(turn * params.headings)) % params.headings;
  const std::int64_t floor = keyframe.floor ? static_cast<std::int64_t>(keyframe.floor->value) : -1;
  return {floor, keyframe.floor ? 0 : square(T.t.z()), square(T.t.x()), square(T.t.y()), heading};
}

/// Keyframes of the observations that queries about the past need.
void protectHistory(const CSceneGraph& graph, std::set<NodeId>& kept) {
  for (const auto& [entity, track] : graph.tracks()) {
    kept.insert(track.front()->keyframe);
    kept.insert(track.back()->keyframe);
    if (track.front()->semantic_class == SemanticClass::kAgent) continue;
    for (std::size_t i = 1; i < track.size(); ++i) {
      if (!track[i]->moved) continue;
      kept.insert(track[i - 1]->keyframe);
      kept.insert(track[i]->keyframe);
    }
  }
}

std::set<NodeId> protectedKeyframes(const CSceneGraph& graph) {
  std::set<NodeId> kept;
  std::set<NodeId> floors;
  for (const auto& keyframe : graph.keyframes()) {
    const bool first_of_floor = keyframe->floor && floors.insert(*keyframe->floor).second;
    if (first_of_floor || kept.empty()) kept.insert(keyframe->id);
  }
  protectHistory(graph, kept);
  return kept;
}

bool hasPrior(const CSceneGraph& graph, NodeId keyframe) {
  const auto& edges = graph.edgesOf(keyframe);
  return std::any_of(edges.begin(), edges.end(),
                     [&](EdgeId id) { return graph.edgeSlots()[id.value]->nodes.size() == 1; });
}

}  // namespace

std::vector<NodeId> surplusKeyframes(const CSceneGraph& graph, const LifeParams& params) {
  const Keyframes& all = graph.keyframes();
  const auto window = static_cast<std::size_t>(params.window);
  std::vector<NodeId> surplus;
  if (all.size() <= window) return surplus;
  std::map<Cell, std::vector<const CNodeKeyframe*>> cells;
  for (std::size_t k = 0; k + window < all.size(); ++k)
    cells[cellOf(*all[k], params)].push_back(all[k].get());

  const auto capacity = static_cast<std::size_t>(params.per_cell);
  std::optional<std::set<NodeId>> kept;
  for (const auto& [cell, members] : cells) {
    if (members.size() <= capacity) continue;
    if (!kept) kept = protectedKeyframes(graph);
    std::size_t excess = members.size() - capacity;
    for (auto member = members.rbegin(); member != members.rend() && excess > 0; ++member) {
      if (kept->contains((*member)->id) || hasPrior(graph, (*member)->id)) continue;
      surplus.push_back((*member)->id);
      --excess;
    }
  }
  if (surplus.size() < static_cast<std::size_t>(params.batch)) return {};
  std::sort(surplus.begin(), surplus.end());
  return surplus;
}

}  // namespace dynemo
