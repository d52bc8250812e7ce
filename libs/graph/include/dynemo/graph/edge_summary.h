#pragma once

#include "dynemo/graph/edge_relative_pose.h"

namespace dynemo {

/// What keyframes that have left the graph said of two pose nodes of any kind.
class CEdgeSummary : public CEdgeRelativePose {
  DEFINE_SERIALIZABLE(CEdgeSummary, dynemo)
 public:
  const char* kind() const override { return "summary"; }
  static Ptr example(std::mt19937_64& rng) { return randomExample<CEdgeSummary>(rng); }
};

}  // namespace dynemo
