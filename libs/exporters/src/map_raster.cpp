#include "map_raster.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace dynemo {
namespace {

constexpr double kLowest_m = 0.2, kHighest_m = 1.8;  // over the ground
/// Points per pixel at which the ink is two thirds of its full strength.
constexpr float kFullInk = 1.5F;

/// Height of the ground under a keyframe in its base frame: the floor's level where it is known,
/// else where the lowest points are.
double groundInBase(const CSceneGraph& graph, const CNodeKeyframe& keyframe,
                    const std::vector<Vector3>& points_base) {
  if (keyframe.floor) {
    const double level_m = graph.getNode<CNodeFloor>(*keyframe.floor).level_m;
    return level_m - keyframe.T_map_base().t.z();
  }
  std::vector<double> heights;
  for (const Vector3& p : points_base) heights.push_back(p.z());
  const auto low = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 50);
  std::nth_element(heights.begin(), low, heights.end());
  return *low;
}

}  // namespace

cv::Size MapView::size() const {
  const Eigen::Vector2d pixels = area_m.sizes() / pixel_m;
  return {std::max(1, static_cast<int>(std::lround(pixels.x()))),
          std::max(1, static_cast<int>(std::lround(pixels.y())))};
}

cv::Point2d MapView::pixel(const Vector3& p_map) const {
  return {(p_map.x() - area_m.min().x()) / pixel_m - 0.5,
          (area_m.max().y() - p_map.y()) / pixel_m - 0.5};
}

cv::Vec3f colorOfTime(std::size_t index, std::size_t count) {
  static const cv::Vec3f stops[] = {{200, 90, 20}, {150, 40, 130}, {30, 110, 240}};  // B G R
  const float at =
      count < 2 ? 0.0F : 2.0F * static_cast<float>(index) / static_cast<float>(count - 1);
  const int left = at < 1.0F ? 0 : 1;
  const float s = at - static_cast<float>(left);
  return stops[left] * (1.0F - s) + stops[left + 1] * s;
}

std::vector<RasterPoint> structurePoints(const CSceneGraph& graph, const PointOwners& owners,
                                         std::size_t budget) {
  std::vector<RasterPoint> all;
  const auto& keyframes = graph.keyframes();
  for (std::size_t k = 0; k < keyframes.size(); ++k) {
    const CNodeKeyframe& keyframe = *keyframes[k];
    if (!keyframe.scan || keyframe.scan->cloud.empty()) continue;
    std::vector<Vector3> points;
    for (const Eigen::Vector3f& p : keyframe.scan->cloud.points)
      points.push_back(keyframe.scan->T_base_lidar * p.cast<double>());
    const double ground_m = groundInBase(graph, keyframe, points);
    const ScanOwners& of_scan = owners.of(keyframe);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double height_m = points[i].z() - ground_m;
      if (!of_scan.isStructure(i) || height_m < kLowest_m || height_m > kHighest_m) continue;
      all.push_back({points[i].cast<float>(), static_cast<std::uint32_t>(k)});
    }
  }
  if (all.size() <= budget) return all;
  std::vector<RasterPoint> kept;
  for (std::size_t i = 0; i < budget; ++i) kept.push_back(all[i * all.size() / budget]);
  return kept;
}

cv::Mat paintStructure(const std::vector<RasterPoint>& points, const std::vector<Pose3>& T_map_base,
                       const MapView& view) {
  const cv::Size size = view.size();
  cv::Mat ink(size, CV_32FC1, cv::Scalar(0)), color(size, CV_32FC3, cv::Scalar::all(0));
  for (const RasterPoint& point : points) {
    const Vector3 p_map = T_map_base[point.keyframe] * point.p_base.cast<double>();
    const cv::Point2d at = view.pixel(p_map);
    if (!(at.x >= 0.0 && at.y >= 0.0 && at.x < size.width - 1 && at.y < size.height - 1)) continue;
    const cv::Vec3f rgb = colorOfTime(point.keyframe, T_map_base.size());
    const int x = static_cast<int>(at.x), y = static_cast<int>(at.y);
    const auto fx = static_cast<float>(at.x - x), fy = static_cast<float>(at.y - y);
    for (int dy = 0; dy < 2; ++dy) {
      for (int dx = 0; dx < 2; ++dx) {
        const float w = (dx ? fx : 1.0F - fx) * (dy ? fy : 1.0F - fy);
        ink.at<float>(y + dy, x + dx) += w;
        color.at<cv::Vec3f>(y + dy, x + dx) += w * rgb;
      }
    }
  }
  cv::Mat picture(size, CV_8UC3, cv::Scalar::all(255));
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const float amount = ink.at<float>(y, x);
      if (amount <= 0.0F) continue;
      const float alpha = 1.0F - std::exp(-amount / kFullInk);
      const cv::Vec3f mixed =
          color.at<cv::Vec3f>(y, x) * (alpha / amount) + cv::Vec3f::all(255.0F * (1.0F - alpha));
      for (int c = 0; c < 3; ++c)
        picture.at<cv::Vec3b>(y, x)[c] = cv::saturate_cast<std::uint8_t>(mixed[c]);
    }
  }
  return picture;
}

}  // namespace dynemo
