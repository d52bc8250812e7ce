#include "dynemo/odometry/deskew.h"

#include "dynemo/odometry/point_times.h"

namespace dynemo {

PointCloud deskew(const PointCloud& cloud, const Pose3& T_base_lidar, const SweepMotion& motion,
                  double at_s) {
  PointCloud still = cloud;
  still.time_offset_s.clear();
  if (cloud.time_offset_s.empty()) return still;
  const double middle_s = middleOfSweep(cloud);
  const PointCarrier carrier(motion, T_base_lidar);
  const Pose3 T_at_middle =
      T_base_lidar.inverse() * motion.at(at_s - middle_s).inverse() * T_base_lidar;
  const Eigen::Matrix3f R = T_at_middle.R.cast<float>();
  const Eigen::Vector3f t = T_at_middle.t.cast<float>();
  const auto middle = static_cast<float>(middle_s);
  for (std::size_t i = 0; i < still.points.size(); ++i) {
    still.points[i] = R * carrier.toReference(cloud.time_offset_s[i] - middle, still.points[i]) + t;
  }
  return still;
}

}  // namespace dynemo
