#include "dynemo/odometry/keyframe_gicp_odometry.h"
#include "dynemo/odometry/local_map_odometry.h"

namespace dynemo {

const ScanOdometryRegistry& scanOdometries() {
  static const ScanOdometryRegistry registry = [] {
    ScanOdometryRegistry r("LiDAR odometry");
    r.add("local_map", makeLocalMapOdometry);
    r.add("keyframe_gicp", makeKeyframeGicpOdometry);
    return r;
  }();
  return registry;
}

std::string toString(OdometryFailure failure) {
  switch (failure) {
    case OdometryFailure::kTooFewPoints:
      return "too few points";
    case OdometryFailure::kStampNotIncreasing:
      return "stamp not after the last one";
    case OdometryFailure::kNoOverlap:
      return "no overlap with the map";
    case OdometryFailure::kNotConverged:
      return "registration did not converge";
  }
  return "unknown failure";
}

}  // namespace dynemo
