// Loop closure on one page: candidates, entity-aware prefilter, matching, verification.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "dynemo/backend/optimizer.h"
#include "dynemo/graph/edge_relative_pose.h"
#include "dynemo/graph/scene_graph.h"
#include "dynemo/loops/candidate_search.h"
#include "dynemo/loops/closure_set.h"
#include "dynemo/loops/entity_aware_matcher.h"
#include "dynemo/loops/loop_record.h"
#include "dynemo/matching/scan_matcher.h"

namespace dynemo {

/// Keyframes that see the same place, found in the graph and tied by scan matching (paper, Sec.
/// IV-C). Sees the graph through const eyes: what it finds comes out as a delta. One per graph.
class LoopCloser {
 public:
  /// Throws ConfigError on an unknown prefilter or matcher.
  explicit LoopCloser(const LoopParams& params);
  /// With a matcher other than the configured one.
  LoopCloser(const LoopParams& params, std::unique_ptr<ScanMatcher> matcher);
  ~LoopCloser();

  /// Closes loops of the newest keyframe, whose estimate is the odometry's prediction, and takes
  /// out closures that contradict. Call once per keyframe, between adding it and optimising; the
  /// delta must be applied.
  GraphDelta close(const CSceneGraph& graph, Optimizer& optimizer);

  /// Takes out closures that the optimised graph contradicts. The delta must be applied.
  GraphDelta review(const CSceneGraph& graph);

  /// A keyframe is about to leave the graph. Its closures are not looked at again: what they say
  /// stays in the edges that replace them. Throws std::out_of_range when there is none of that id.
  void forget(const CSceneGraph& graph, NodeId keyframe);

  /// Every decision so far, in order.
  const std::vector<LoopRecord>& records() const { return records_; }
  /// Closures in the graph.
  std::size_t closures() const;
  const std::map<std::string, std::uint64_t>& warnings() const { return warnings_; }

 private:
  /// A scan matched from one hypothesis of the relative pose.
  struct Attempt {
    LoopRecord record;
    double range_m = 0.0;  ///< mean of the later scan's points
    std::optional<PoseEstimate> measured;
    double fit = 0.0;
    /// The graph contradicts it: other closures must speak for it.
    bool doubtful = false;
    /// Share of the measurement's deviation from the graph that the graph's own uncertainty
    /// explains, in (0, 1].
    double explained = 1.0;
    bool isBetterThan(const Attempt& other) const;
  };
  /// A closure of the set and what was written about it.
  struct Entry {
    LoopRecord record;
    double explained = 1.0;
    int contradicted = 0;  ///< times that the optimised graph threw it out
    std::optional<EdgeId> edge;
  };

  std::vector<LoopPair> pairs(const CSceneGraph& graph, Optimizer& optimizer);
  Attempt attempt(const CSceneGraph& graph, const LoopPair& pair);
  Attempt matchFrom(const CSceneGraph& graph, const LoopPair& pair, const PoseEstimate& seed,
                    SeedOrigin origin);
  void verify(const LoopPair& pair, Attempt& attempt) const;
  void reject(LoopRecord record);
  void add(Attempt attempt);
  void settle(const CSceneGraph& graph, Stamp now, GraphDelta& delta);
  void reviewInto(const CSceneGraph& graph, Stamp now, GraphDelta& delta);
  void insert(std::size_t index, Stamp now, const CSceneGraph& graph, GraphDelta& delta);
  void takeOut(std::size_t index, Stamp now, const std::string& reason, GraphDelta& delta);
  double correlation(std::size_t index) const;
  RobustKernel kernel(const CEdgeRelativePose& edge, double explained,
                      const CSceneGraph& graph) const;

  LoopParams params_;
  CandidateSearch search_;
  EntityAwareMatcher matcher_;
  OdometryChain chain_;
  ClosureSet closures_;
  std::vector<Entry> entries_;  ///< of closures_, by index
  std::vector<LoopRecord> records_;
  std::map<std::string, std::uint64_t> warnings_;
};

}  // namespace dynemo
