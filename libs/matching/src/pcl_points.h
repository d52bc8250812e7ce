// Conversions for PCL's registrations; only for the files that include PCL anyway.
#pragma once

#include <pcl/console/print.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/registration/registration.h>

#include "dynemo/core/se3.h"
#include "dynemo/matching/scan_matcher.h"
#include "dynemo/odometry/surface_points.h"

namespace dynemo {

inline pcl::PointCloud<pcl::PointXYZ>::Ptr toPcl(const SurfacePoints& surface) {
  pcl::PointCloud<pcl::PointXYZ>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZ>());
  cloud->reserve(surface.size());
  for (const Eigen::Vector3f& p : surface.points) cloud->emplace_back(p.x(), p.y(), p.z());
  return cloud;
}

inline Eigen::Matrix4f toPcl(const Pose3& T) {
  Eigen::Matrix4d M = Eigen::Matrix4d::Identity();
  M.topLeftCorner<3, 3>() = T.R;
  M.topRightCorner<3, 1>() = T.t;
  return M.cast<float>();
}

/// The rotation of single precision is made a proper one.
inline Pose3 fromPcl(const Eigen::Matrix4f& M) {
  const Eigen::Matrix4d T = M.cast<double>();
  if (!T.allFinite()) return {T.topLeftCorner<3, 3>(), T.topRightCorner<3, 1>()};
  return {nearestRotation(T.topLeftCorner<3, 3>()), T.topRightCorner<3, 1>()};
}

/// T_target_source of a registration whose clouds are set.
inline Expected<Pose3, MatchFailure> align(
    pcl::Registration<pcl::PointXYZ, pcl::PointXYZ>& registration,
    const Pose3& T_target_source_guess) {
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
  pcl::PointCloud<pcl::PointXYZ> aligned;
  try {
    registration.align(aligned, toPcl(T_target_source_guess));
  } catch (const std::exception&) {
    return make_unexpected(MatchFailure::kNotConverged);
  }
  if (!registration.hasConverged()) return make_unexpected(MatchFailure::kNotConverged);
  return fromPcl(registration.getFinalTransformation());
}

}  // namespace dynemo
