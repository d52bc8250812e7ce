// Which entities leave a pair of scans before it is matched (paper, Sec. IV-C).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "dynemo/core/registry.h"
#include "dynemo/loops/loop_pair.h"

namespace dynemo {

/// What became of one entity.
struct EntityDecision {
  EntityId entity{};
  bool removed = false;
  /// "moved 0.42 m", "agent", "static", …
  std::string reason;
  /// Of its fragments in the two scans.
  std::size_t points_earlier = 0, points_later = 0;
};

struct FilteredPair {
  /// Indices into the keyframes' scans, ascending.
  PointIndices removed_earlier, removed_later;
  std::vector<EntityDecision> entities;  ///< by id
};

class EntityPrefilter {
 public:
  virtual ~EntityPrefilter() = default;
  /// The points to leave out if T_earlier_later were `hypothesis`.
  virtual FilteredPair filter(const CSceneGraph& graph, const LoopPair& pair,
                              const PoseEstimate& hypothesis) const = 0;
};

/// By name: "none"; "always", every entity; "motion", those that moved in between.
using EntityPrefilterRegistry = Registry<EntityPrefilter, const PrefilterParams&>;
const EntityPrefilterRegistry& entityPrefilters();

}  // namespace dynemo
