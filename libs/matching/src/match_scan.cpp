#include "dynemo/matching/match_scan.h"

#include <mutex>

#include "dynemo/odometry/cell_index.h"
#include "dynemo/odometry/kd_tree_target.h"
#include "dynemo/odometry/worker_pool.h"

namespace dynemo {
namespace {

double meanRange(const SurfacePoints& surface) {
  double sum_m = 0.0;
  for (const Eigen::Vector3f& p : surface.points) sum_m += static_cast<double>(p.norm());
  return surface.size() == 0 ? 0.0 : sum_m / static_cast<double>(surface.size());
}

}  // namespace

struct MatchScan::Content {
  Content(SurfacePoints points, const Eigen::Vector3f& sensor_base, double leaf)
      : surface(std::move(points)),
        sensor(sensor_base),
        leaf_m(leaf),
        mean_range_m(meanRange(surface)) {}

  SurfacePoints surface;
  Eigen::Vector3f sensor;  ///< in the base frame
  double leaf_m;
  double mean_range_m;
  mutable std::once_flag tree_built, space_built;
  mutable std::unique_ptr<const KdTreeTarget> tree;
  mutable std::unique_ptr<const SeenSpace> space;
};

MatchScan::MatchScan(const Scan& scan, const SurfaceParams& params) {
  WorkerPool here(1);
  content_ = std::make_shared<const Content>(extractSurface(scan, {}, 0.0, {}, {}, params, here),
                                             scan.T_base_lidar.t.cast<float>(), params.leaf_m);
}

MatchScan MatchScan::without(const Scan& scan, std::span<const std::uint32_t> removed) const {
  if (removed.empty()) return *this;
  const auto inverse_leaf = static_cast<float>(1.0 / content_->leaf_m);
  const Eigen::Matrix3f R = scan.T_base_lidar.R.cast<float>();
  const Eigen::Vector3f t = scan.T_base_lidar.t.cast<float>();
  CellIndex touched(removed.size());
  for (const std::uint32_t i : removed)
    touched.findOrAdd(cellOf(R * scan.cloud.points[i] + t, inverse_leaf));
  SurfacePoints kept;
  for (std::size_t i = 0; i < size(); ++i) {
    const Eigen::Vector3f& p = surface().points[i];
    if (touched.find(cellOf(p, inverse_leaf)) != CellIndex::kNone) continue;
    kept.points.push_back(p);
    kept.normals.push_back(surface().normals[i]);
  }
  return MatchScan(
      std::make_shared<const Content>(std::move(kept), content_->sensor, content_->leaf_m));
}

const SurfacePoints& MatchScan::surface() const { return content_->surface; }

double MatchScan::meanRange_m() const { return content_->mean_range_m; }

const RegistrationTarget& MatchScan::target() const {
  std::call_once(content_->tree_built, [this] {
    content_->tree = std::make_unique<const KdTreeTarget>(content_->surface);
  });
  return *content_->tree;
}

const SeenSpace& MatchScan::seenSpace() const {
  std::call_once(content_->space_built, [this] {
    content_->space = std::make_unique<const SeenSpace>(content_->surface.points, content_->sensor);
  });
  return *content_->space;
}

}  // namespace dynemo
