#include "dynemo/prep/tag_survey.h"

#include <algorithm>
#include <cmath>

#include "dynemo/perception/camera_projection.h"
#include "dynemo/perception/tag_pose.h"

namespace dynemo {
namespace {

constexpr double kLongestStep_s = 1.0;
constexpr double kNeighbour_m = 1.0;
/// Fewer points on a tag say little.
constexpr std::size_t kMinSizePoints = 5;
/// Tags are not smaller or larger than this.
constexpr double kSmallest_m = 0.01, kLargest_m = 3.0;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Pose of a tag of 1 m; distances scale with the true size.
std::optional<Pose3> unitPose(const TagCornerObservation& corners, const CameraModel& camera) {
  EntityModel model;
  model.tags = {TagModel{corners.tag_id, 1.0, Pose3()}};
  const auto solution = solveEntityPose(model, camera, std::span(&corners, 1), {});
  if (!solution) return std::nullopt;
  return solution->best.T_camera_entity;
}

/// Whether the pixel lies within the quadrilateral, given in either sense of rotation.
bool inside(const std::array<Vector2, 4>& quad, const Vector2& p) {
  int positive = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vector2 edge = quad[(i + 1) % 4] - quad[i], to = p - quad[i];
    positive += edge.x() * to.y() - edge.y() * to.x() > 0 ? 1 : 0;
  }
  return positive == 0 || positive == 4;
}

using NeighboursByTag = std::map<int, std::vector<SurveyedTag::Neighbour>>;

struct Sighting {
  Stamp stamp;
  std::string camera;
  double edge_px = 0.0;
  std::optional<Pose3> T_camera_unit_tag;
  std::optional<Pose3> T_odom_camera;
};

/// Points of the scan in the camera frame at the image's stamp, with their pixels.
struct VisiblePoint {
  Vector3 p_camera;
  Vector2 pixel;
};

std::vector<VisiblePoint> visiblePoints(const SensorFrame& frame, const CameraImage& image) {
  std::vector<VisiblePoint> points;
  if (!frame.scan) return points;
  Pose3 T_image_scan;
  if (frame.odometry && image.odometry)
    T_image_scan = image.odometry->T_odom_base.inverse() * frame.odometry->T_odom_base;
  const Pose3 T_camera_lidar =
      image.T_base_camera.inverse() * T_image_scan * frame.scan->T_base_lidar;
  for (const Eigen::Vector3f& p : frame.scan->cloud.points) {
    const Vector3 p_camera = T_camera_lidar * Vector3(p.cast<double>());
    if (p_camera.z() <= 0) continue;
    const auto projection = project(image.model, p_camera);
    if (projection) points.push_back({p_camera, projection->pixel});
  }
  return points;
}

}  // namespace

struct TagSurvey::Impl {
  explicit Impl(const TagSurveyParams& p) : params(p), finder(p.family, p.finder) {}

  void addImage(const SensorFrame& frame, const CameraImage& image);
  void measureSizes(const TagCornerObservation& tag, const Pose3& T_camera_unit_tag,
                    const std::vector<VisiblePoint>& points);
  std::optional<double> speed(int id, double size_m) const;
  NeighboursByTag neighbours(double size_m) const;

  TagSurveyParams params;
  TagFinder finder;
  std::uint64_t images = 0;
  std::map<int, std::vector<Sighting>> sightings;
  std::map<int, std::vector<double>> sizes_m;
  /// Per image with several tags, their ids and places in the camera frame for a size of 1 m.
  std::vector<std::vector<std::pair<int, Vector3>>> together;
};

TagSurvey::TagSurvey(const TagSurveyParams& params) : impl_(std::make_unique<Impl>(params)) {}
TagSurvey::~TagSurvey() = default;
TagSurvey::TagSurvey(TagSurvey&&) noexcept = default;

void TagSurvey::add(const SensorFrame& frame) {
  for (const CameraImage& image : frame.images)
    if (!image.grey.empty()) impl_->addImage(frame, image);
}

void TagSurvey::Impl::addImage(const SensorFrame& frame, const CameraImage& image) {
  ++images;
  const bool calibrated = image.model.valid() && image.grey.cols == image.model.width &&
                          image.grey.rows == image.model.height;
  std::optional<std::vector<VisiblePoint>> points;
  std::vector<std::pair<int, Vector3>> places;
  for (const FoundTag& found : finder.find(image.grey)) {
    const TagCornerObservation& tag = found.observation;
    Sighting sighting;
    sighting.stamp = image.stamp;
    sighting.camera = image.label;
    sighting.edge_px = effectiveEdge_px(tag);
    if (calibrated) sighting.T_camera_unit_tag = unitPose(tag, image.model);
    if (sighting.T_camera_unit_tag) places.emplace_back(tag.tag_id, sighting.T_camera_unit_tag->t);
    if (image.odometry) sighting.T_odom_camera = image.odometry->T_odom_base * image.T_base_camera;
    if (sighting.T_camera_unit_tag && !params.size_m) {
      if (!points) points = visiblePoints(frame, image);
      measureSizes(tag, *sighting.T_camera_unit_tag, *points);
    }
    sightings[tag.tag_id].push_back(std::move(sighting));
  }
  if (places.size() > 1) together.push_back(std::move(places));
}

/// A point on the plane of the tag tells how far away that plane is, thus how large the tag is: the
/// plane of a tag of size s goes through s·t, where t is the origin of one of 1 m.
void TagSurvey::Impl::measureSizes(const TagCornerObservation& tag, const Pose3& T_camera_unit_tag,
                                   const std::vector<VisiblePoint>& points) {
  const Vector3 normal = T_camera_unit_tag.R.col(2);
  const double unit_distance = normal.dot(T_camera_unit_tag.t);
  if (std::abs(unit_distance) < 1e-3) return;
  for (const VisiblePoint& point : points) {
    if (!inside(tag.corners_px, point.pixel)) continue;
    const double size_m = normal.dot(point.p_camera) / unit_distance;
    if (size_m > kSmallest_m && size_m < kLargest_m) sizes_m[tag.tag_id].push_back(size_m);
  }
}

/// Over the whole way between the first and the last sighting of a stretch, so that the noise of
/// single poses does not look like motion.
std::optional<double> TagSurvey::Impl::speed(int id, double size_m) const {
  std::vector<double> speeds;
  const auto& all = sightings.at(id);
  const auto position = [&](const Sighting& s) -> Vector3 {
    return *s.T_odom_camera * Vector3(size_m * s.T_camera_unit_tag->t);
  };
  for (std::size_t i = 0; i < all.size(); ++i)
    for (std::size_t j = i + 1; j < all.size(); ++j) {
      const double dt_s = secondsBetween(all[i].stamp, all[j].stamp);
      if (dt_s > kLongestStep_s) break;
      if (dt_s < 0.3 * kLongestStep_s || all[i].camera != all[j].camera) continue;
      if (!all[i].T_odom_camera || !all[j].T_odom_camera || !all[i].T_camera_unit_tag ||
          !all[j].T_camera_unit_tag)
        continue;
      speeds.push_back((position(all[j]) - position(all[i])).norm() / dt_s);
    }
  if (speeds.empty()) return std::nullopt;
  return median(speeds);
}

NeighboursByTag TagSurvey::Impl::neighbours(double size_m) const {
  std::map<std::pair<int, int>, std::vector<double>> distances;
  for (const auto& tags : together)
    for (const auto& [id, t_unit] : tags)
      for (const auto& [other_id, other_t_unit] : tags)
        if (id != other_id)
          distances[{id, other_id}].push_back(size_m * (other_t_unit - t_unit).norm());
  NeighboursByTag near;
  for (const auto& [pair, values] : distances) {
    const double distance_m = median(values);
    if (distance_m < kNeighbour_m)
      near[pair.first].push_back({pair.second, static_cast<int>(values.size()), distance_m});
  }
  for (auto& [id, list] : near)
    std::stable_sort(list.begin(), list.end(),
                     [](const auto& a, const auto& b) { return a.times > b.times; });
  return near;
}

std::uint64_t TagSurvey::imagesSearched() const { return impl_->images; }

std::optional<double> TagSurvey::commonSize_m() const {
  if (impl_->params.size_m) return impl_->params.size_m;
  std::vector<double> sizes;
  for (const auto& [id, values] : impl_->sizes_m)
    if (values.size() >= kMinSizePoints) sizes.push_back(median(values));
  if (sizes.empty()) return std::nullopt;
  return median(sizes);
}

std::vector<SurveyedTag> TagSurvey::tags() const {
  std::vector<SurveyedTag> tags;
  const auto common_size_m = commonSize_m();
  auto neighbours = common_size_m ? impl_->neighbours(*common_size_m) : NeighboursByTag();
  for (const auto& [id, sightings] : impl_->sightings) {
    SurveyedTag tag;
    tag.id = id;
    tag.sightings = static_cast<int>(sightings.size());
    const auto [smallest, largest] =
        std::minmax_element(sightings.begin(), sightings.end(),
                            [](const auto& a, const auto& b) { return a.edge_px < b.edge_px; });
    tag.min_edge_px = smallest->edge_px;
    tag.max_edge_px = largest->edge_px;
    const auto sizes = impl_->sizes_m.find(id);
    if (sizes != impl_->sizes_m.end()) {
      tag.size_points = static_cast<int>(sizes->second.size());
      if (sizes->second.size() >= kMinSizePoints) tag.measured_size_m = median(sizes->second);
    }
    if (common_size_m) {
      tag.speed_m_s = impl_->speed(id, *common_size_m);
      tag.neighbours = neighbours[id];
    }
    tags.push_back(std::move(tag));
  }
  return tags;
}

}  // namespace dynemo
