// Two keyframes that may see the same place.
#pragma once

#include <optional>
#include <vector>

#include "dynemo/loops/shared_entities.h"

namespace dynemo {

/// Why a pair is looked at.
enum class LoopOrigin { kDistance, kUncertainty, kEntities };
const char* loopOriginName(LoopOrigin origin);

/// Keyframes by their index in CSceneGraph::keyframes(); earlier < later.
struct LoopCandidate {
  std::size_t earlier = 0, later = 0;
  LoopOrigin origin = LoopOrigin::kDistance;
  double distance_m = 0.0;  ///< of the estimates, seen from above
  double path_m = 0.0;      ///< driven between the two
};

/// A candidate with everything that is known of it before the scans are compared. Refers to the
/// graph.
struct LoopPair {
  LoopCandidate candidate;
  const CNodeKeyframe* earlier = nullptr;
  const CNodeKeyframe* later = nullptr;
  /// T_earlier_later by the graph.
  PoseEstimate predicted;
  std::vector<SharedEntity> shared;
  std::optional<EntityConsensus> consensus;
};

}  // namespace dynemo
