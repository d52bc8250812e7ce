#include "dynemo/odometry/deskew.h"

namespace dynemo {

PointCloud deskew(const PointCloud& cloud, const std::vector<float>& times_s,
                  const Pose3& T_base_lidar, const BodyTwist& twist, double reference_s) {
  PointCloud still = cloud;
  still.time_offset_s.clear();
  if (times_s.size() != cloud.size()) return still;
  // The sensor's own twist: the motion of its origin in its axes (adjoint of T_base_lidar⁻¹).
  const Matrix3 R_lidar_base = T_base_lidar.R.transpose();
  const Eigen::Vector3f angular = (R_lidar_base * twist.angular_rad_s).cast<float>();
  const Eigen::Vector3f linear =
      (R_lidar_base * (twist.linear_m_s + twist.angular_rad_s.cross(T_base_lidar.t))).cast<float>();
  const auto reference = static_cast<float>(reference_s);
  for (std::size_t i = 0; i < still.points.size(); ++i) {
    still.points[i] =
        carriedToReference<float>(linear, angular, times_s[i] - reference, still.points[i]);
  }
  return still;
}

}  // namespace dynemo
