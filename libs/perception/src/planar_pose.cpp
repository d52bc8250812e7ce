#include "planar_pose.h"

#include <opencv2/calib3d.hpp>

#include "dynemo/perception/camera_projection.h"

namespace dynemo {
namespace {

std::optional<std::array<Vector3, 4>> bearings(const CameraModel& camera,
                                               const TagCornerObservation& tag) {
  std::array<Vector3, 4> rays;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const auto ray = bearing(camera, tag.corners_px[i]);
    if (!ray) return std::nullopt;
    rays[i] = *ray;
  }
  return rays;
}

/// IPPE_SQUARE wants exactly this order: (−,+), (+,+), (+,−), (−,−) half sides, which is that of
/// the tag's corners.
std::vector<cv::Point3d> squareCorners(double size_m) {
  const double h = 0.5 * size_m;
  return {{-h, h, 0.0}, {h, h, 0.0}, {h, -h, 0.0}, {-h, -h, 0.0}};
}

Pose3 fromOpenCv(const cv::Mat& rotation_vector, const cv::Mat& translation) {
  const auto vector = [](const cv::Mat& m) {
    return Vector3(m.at<double>(0), m.at<double>(1), m.at<double>(2));
  };
  return {expSO3(vector(rotation_vector)), vector(translation)};
}

}  // namespace

std::vector<Pose3> planarPoses(const CameraModel& camera, const TagCornerObservation& tag,
                               double size_m) {
  const auto rays = bearings(camera, tag);
  if (!rays) return {};
  const Vector3 centre = ((*rays)[0] + (*rays)[1] + (*rays)[2] + (*rays)[3]).normalized();
  const Matrix3 R_camera_turned =
      Eigen::Quaterniond::FromTwoVectors(Vector3::UnitZ(), centre).toRotationMatrix();
  std::vector<cv::Point2d> points;
  for (const Vector3& ray : *rays) {
    const Vector3 turned = R_camera_turned.transpose() * ray;
    if (!(turned.z() > 0.0)) return {};
    points.emplace_back(turned.x() / turned.z(), turned.y() / turned.z());
  }
  std::vector<cv::Mat> rotations, translations;
  cv::solvePnPGeneric(squareCorners(size_m), points, cv::Mat::eye(3, 3, CV_64F), cv::noArray(),
                      rotations, translations, false, cv::SOLVEPNP_IPPE_SQUARE);
  std::vector<Pose3> poses;
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    const Pose3 T_turned_tag = fromOpenCv(rotations[i], translations[i]);
    if (!T_turned_tag.isFinite()) continue;
    poses.push_back(Pose3(R_camera_turned, Vector3::Zero()) * T_turned_tag);
  }
  return poses;
}

}  // namespace dynemo
