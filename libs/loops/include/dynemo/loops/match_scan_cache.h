#pragma once

#include <deque>
#include <map>

#include "dynemo/graph/scene_graph.h"
#include "dynemo/matching/match_scan.h"

namespace dynemo {

/// Keyframes' scans ready for matching, the latest used so many of them.
class MatchScanCache {
 public:
  MatchScanCache(const SurfaceParams& params, std::size_t capacity)
      : params_(params), capacity_(capacity) {}

  /// The keyframe must have a scan.
  MatchScan get(const CNodeKeyframe& keyframe);

 private:
  SurfaceParams params_;
  std::size_t capacity_;
  std::map<NodeId, MatchScan> scans_;
  std::deque<NodeId> by_use_;  ///< latest last
};

}  // namespace dynemo
