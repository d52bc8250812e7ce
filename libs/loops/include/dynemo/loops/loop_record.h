// What was decided about a pair of keyframes and why, as loops.csv lists it.
#pragma once

#include <optional>
#include <string>

#include "dynemo/loops/entity_prefilter.h"
#include "dynemo/loops/loop_pair.h"
#include "dynemo/matching/scan_matcher.h"

namespace dynemo {

enum class LoopDecision {
  kAccepted,
  kRejected,
  kRemoved  ///< had been accepted
};
const char* loopDecisionName(LoopDecision decision);

/// Where the search for the relative pose started.
enum class SeedOrigin { kGraph, kEntities };

struct LoopRecord {
  /// Of the newest keyframe when it was decided.
  Stamp decided;
  NodeId earlier{}, later{};
  Stamp earlier_stamp, later_stamp;
  LoopCandidate candidate;
  /// What became of the entities, and how many points left the scans.
  std::vector<EntityDecision> entities;
  std::size_t removed_earlier = 0, removed_later = 0;
  std::size_t scan_points_earlier = 0, scan_points_later = 0;
  /// T_earlier_later.
  Pose3 seed;
  SeedOrigin seed_origin = SeedOrigin::kGraph;
  /// Share of inliers at the seed, before the match.
  std::optional<double> seed_inlier_ratio;
  std::optional<ScanMatch> match;
  /// Squared Mahalanobis distance of the match from the graph's estimate.
  std::optional<double> graph_distance;
  LoopDecision decision = LoopDecision::kRejected;
  std::string reason;
  std::optional<EdgeId> edge;  ///< of an accepted or removed closure
};

/// Column names of loops.csv, and one row; without line ends.
std::string loopRecordHeader();
std::string loopRecordRow(const LoopRecord& record);

}  // namespace dynemo
