// The earlier keyframes that the newest one may close a loop with.
#pragma once

#include <optional>
#include <vector>

#include "dynemo/backend/optimizer.h"
#include "dynemo/graph/scene_graph.h"
#include "dynemo/loops/loop_pair.h"
#include "dynemo/loops/odometry_chain.h"

namespace dynemo {

/// By distance seen from above, floor, path and time since the last closure; the radius is fixed or
/// grows with the pair's marginal covariance. S-Graphs' gate (H. Bavle et al., "S-Graphs+", RA-L
/// 2023, as its code behaves) is the configuration max_distance 1 m, min_path 3 m, spacing 5 m.
/// With entity evidence, also keyframes which see the same objects, at the distance that the
/// objects tell.
class CandidateSearch {
 public:
  CandidateSearch(const CandidateParams& params, const EntityEvidenceParams& entities)
      : params_(params), entities_(entities) {}

  /// Candidates of the newest keyframe, best first: nearest first, then those from entities. The
  /// chain covers the graph; `last_closure` is the later keyframe of the newest closure. Only the
  /// gate by uncertainty asks the optimizer.
  std::vector<LoopCandidate> search(const CSceneGraph& graph, const OdometryChain& chain,
                                    std::optional<std::size_t> last_closure,
                                    Optimizer& optimizer) const;

 private:
  class Query;
  CandidateParams params_;
  EntityEvidenceParams entities_;
};

/// Joint marginals of one keyframe with others: T_other_keyframe of each, in the order of `others`.
/// The failure says why there are none.
Expected<std::vector<PoseEstimate>, std::string> relativeEstimates(
    const CSceneGraph& graph, Optimizer& optimizer, const CNodeKeyframe& keyframe,
    const std::vector<const CNodeKeyframe*>& others);

}  // namespace dynemo
