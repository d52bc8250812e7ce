#include "look_plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

namespace dynemo {
namespace {

constexpr double kBlock_m = 3.2;

}  // namespace

std::vector<std::uint32_t> spreadViewpoints(const std::vector<Viewpoint>& views,
                                            const Vector3& p_map, double distance_m,
                                            std::size_t most) {
  std::vector<std::uint32_t> near;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if ((views[i].p_map - p_map).squaredNorm() <= distance_m * distance_m)
      near.push_back(static_cast<std::uint32_t>(i));
  }
  if (near.size() <= most) return near;
  // The whole time weighs as much as the distance.
  const double time_s = secondsBetween(views[near.front()].stamp, views[near.back()].stamp);
  const double distance_per_s = distance_m / std::max(time_s, 1e-9);
  std::vector<double> apart2(near.size(), std::numeric_limits<double>::infinity());
  std::vector<std::uint32_t> chosen;
  // Farthest first, beginning with the last: what is there in the end.
  std::size_t next = near.size() - 1;
  while (chosen.size() < most) {
    const Viewpoint& view = views[near[next]];
    chosen.push_back(near[next]);
    std::size_t farthest = 0;
    for (std::size_t i = 0; i < near.size(); ++i) {
      const Viewpoint& other = views[near[i]];
      const double later_m = distance_per_s * secondsBetween(view.stamp, other.stamp);
      apart2[i] = std::min(apart2[i], (other.p_map - view.p_map).squaredNorm() + later_m * later_m);
      if (apart2[i] > apart2[farthest]) farthest = i;
    }
    next = farthest;
    if (apart2[next] <= 0.0) break;
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

LookPlan::LookPlan(const std::vector<SeenPlace>& places, const std::vector<std::uint32_t>& indices,
                   const std::vector<Viewpoint>& scans, double max_range_m, int most)
    : blocks_of_scan_(scans.size()) {
  std::map<std::array<int, 3>, std::vector<std::uint32_t>> blocks;
  for (const std::uint32_t i : indices) {
    const Vector3 at = (places[i].middle.cast<double>() / kBlock_m).array().floor();
    blocks[{static_cast<int>(at.x()), static_cast<int>(at.y()), static_cast<int>(at.z())}]
        .push_back(i);
  }
  const double reach_m = max_range_m + 0.5 * std::sqrt(3.0) * kBlock_m;
  first_.push_back(0);
  places_.reserve(indices.size());
  for (const auto& [block, list] : blocks) {
    const Vector3 middle = kBlock_m * (Vector3(block[0], block[1], block[2]).array() + 0.5);
    for (const std::uint32_t scan :
         spreadViewpoints(scans, middle, reach_m, static_cast<std::size_t>(most))) {
      blocks_of_scan_[scan].push_back(static_cast<std::uint32_t>(first_.size() - 1));
    }
    places_.insert(places_.end(), list.begin(), list.end());
    first_.push_back(static_cast<std::uint32_t>(places_.size()));
  }
}

}  // namespace dynemo
