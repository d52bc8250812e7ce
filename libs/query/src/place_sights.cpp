#include "place_sights.h"

#include <numeric>

namespace dynemo {

PlaceSights::PlaceSights(std::vector<SeenPlace> places, std::vector<Viewpoint> scans,
                         const StructureParams& params, const SightParams& sight,
                         AlongSurface along)
    : places_(std::move(places)),
      sights_(places_.size()),
      scans_(std::move(scans)),
      params_(params),
      sight_(sight),
      along_(along) {
  std::vector<std::uint32_t> all(places_.size());
  std::iota(all.begin(), all.end(), 0u);
  plan_ = LookPlan(places_, all, scans_, params_.max_range_m, params_.max_looks);
}

void PlaceSights::look(std::size_t scan, const BeamGrid& beams, const Pose3& T_map_lidar) {
  const Eigen::Matrix3f R_lidar_map = T_map_lidar.R.transpose().cast<float>();
  const Eigen::Vector3f origin = T_map_lidar.t.cast<float>();
  const auto max_range_m = static_cast<float>(params_.max_range_m);
  plan_.forEachPlace(scan, [&](std::uint32_t i) {
    const SeenPlace& place = places_[i];
    const Eigen::Vector3f ray = place.middle - origin;
    const float range_m = ray.norm();
    if (range_m > max_range_m) return;
    const bool steep = isSteep(ray / range_m, place.normal);
    if (!steep && along_ == AlongSurface::kNothing) return;
    const Sight sight = beams.look(R_lidar_map * ray, sight_);
    if (steep || sight == Sight::kHit) sights_[i].add(sight);
  });
}

bool PlaceSights::lookCloser() {
  if (closer_) return false;
  closer_ = true;
  std::vector<std::uint32_t> open;
  for (std::uint32_t i = 0; i < places_.size(); ++i) {
    if (sights_[i].isClear(params_)) continue;
    sights_[i] = {};
    open.push_back(i);
  }
  plan_ = LookPlan(places_, open, scans_, params_.max_range_m, kCloser * params_.max_looks);
  return !open.empty();
}

}  // namespace dynemo
