#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "dynemo/graph/scene_graph.h"

namespace dynemo {

using EntityTrack = std::vector<std::shared_ptr<CNodeEntity>>;

/// A box in the entity's frame [m].
struct Extent {
  Vector3 min = Vector3::Constant(-0.2), max = Vector3::Constant(0.2);
};

/// The points of an entity's fragments at all its observations, in its own frame.
std::vector<Vector3> fragmentPoints(const CSceneGraph& graph, const EntityTrack& track);

/// The box that holds nearly all points; empty when there are too few of them to tell.
std::optional<Extent> extentOf(std::vector<Vector3> points);

/// "box 1": the name with the id, which is not repeated when the name holds it.
std::string entityTitle(const CNodeEntity& node);

}  // namespace dynemo
