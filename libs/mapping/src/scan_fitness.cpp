#include <limits>
#include <nanoflann.hpp>

#include "dynemo/mapping/odometry_noise.h"

namespace dynemo {
namespace {

struct BasePoints {
  std::vector<Eigen::Vector3f> points;
  std::size_t kdtree_get_point_count() const { return points.size(); }
  float kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return points[i][static_cast<Eigen::Index>(axis)];
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

BasePoints inBase(const Scan& scan, const Pose3& T_target_base) {
  const Pose3 T = T_target_base * scan.T_base_lidar;
  const Eigen::Matrix3f R = T.R.cast<float>();
  const Eigen::Vector3f t = T.t.cast<float>();
  BasePoints out;
  out.points.reserve(scan.cloud.size());
  for (const auto& p : scan.cloud.points) out.points.push_back(R * p + t);
  return out;
}

}  // namespace

double scanFitness(const Scan& a, const Scan& b, const Pose3& T_a_b) {
  if (a.cloud.empty() || b.cloud.empty()) return std::numeric_limits<double>::infinity();
  using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, BasePoints>,
                                                   BasePoints, 3>;
  const BasePoints target = inBase(a, Pose3()), source = inBase(b, T_a_b);
  const Tree tree(3, target, {10});
  double sum_m2 = 0.0;
  for (const auto& p : source.points) {
    std::uint32_t index = 0;
    float distance_m2 = 0.0f;
    tree.knnSearch(p.data(), 1, &index, &distance_m2);
    sum_m2 += static_cast<double>(distance_m2);
  }
  return sum_m2 / static_cast<double>(source.points.size());
}

}  // namespace dynemo
