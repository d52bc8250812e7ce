#include "annealed_gicp.h"
#include "mrpt_icp.h"
#include "pcl_gicp.h"
#include "pcl_ndt.h"

namespace dynemo {

const ScanMatcherRegistry& scanMatchers() {
  static const ScanMatcherRegistry registry = [] {
    ScanMatcherRegistry r("scan matcher");
    r.add("mrpt_icp", makeMrptIcp);
    r.add("annealed_gicp", makeAnnealedGicp);
    r.add("pcl_gicp", makePclGicp);
    r.add("pcl_ndt", makePclNdt);
    return r;
  }();
  return registry;
}

std::string toString(MatchFailure failure) {
  switch (failure) {
    case MatchFailure::kTooFewPoints:
      return "too few points";
    case MatchFailure::kNoOverlap:
      return "no overlap";
    case MatchFailure::kNotConverged:
      return "not converged";
    case MatchFailure::kDegenerate:
      return "degenerate";
    case MatchFailure::kContradicted:
      return "contradicted by free space";
  }
  return "unknown failure";
}

}  // namespace dynemo
