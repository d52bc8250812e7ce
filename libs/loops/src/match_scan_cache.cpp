#include "dynemo/loops/match_scan_cache.h"

#include <algorithm>

namespace dynemo {

MatchScan MatchScanCache::get(const CNodeKeyframe& keyframe) {
  const auto use = std::find(by_use_.begin(), by_use_.end(), keyframe.id);
  if (use != by_use_.end()) by_use_.erase(use);
  by_use_.push_back(keyframe.id);
  auto it = scans_.find(keyframe.id);
  if (it == scans_.end())
    it = scans_.emplace(keyframe.id, MatchScan(*keyframe.scan, params_)).first;
  if (by_use_.size() > capacity_) {
    scans_.erase(by_use_.front());
    by_use_.pop_front();
  }
  return it->second;
}

}  // namespace dynemo
