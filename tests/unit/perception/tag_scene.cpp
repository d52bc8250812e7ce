#include "tag_scene.h"

#include <apriltag/apriltag.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <stdexcept>

#include "dynemo/perception/camera_projection.h"
#include "dynemo/perception/tag_family.h"

namespace dynemo::test {
namespace {

constexpr int kSamplesPerSide = 4;
constexpr double kPaper = 220.0, kInk = 30.0, kBackground = 128.0;

/// image_u8_destroy is in another library; it is two calls of free.
void freeImage(image_u8_t* image) {
  std::free(image->buf);
  std::free(image);
}

/// The printed sheet of one tag: cells of ink and paper, including the border.
class Sheet {
 public:
  Sheet(const std::string& family_name, int tag_id, double size_m)
      : family_(makeTagFamily(family_name)),
        image_(apriltag_to_image(family_.get(), tag_id), freeImage),
        cell_m_(size_m / family_->width_at_border) {}

  double halfSide_m() const { return 0.5 * cell_m_ * image_->width; }

  /// Brightness at a point of the tag's plane; negative off the sheet.
  double at(double x_m, double y_m) const {
    const int column = static_cast<int>(std::floor((x_m + halfSide_m()) / cell_m_));
    const int row = static_cast<int>(std::floor((y_m + halfSide_m()) / cell_m_));
    if (column < 0 || row < 0 || column >= image_->width || row >= image_->height) return -1.0;
    return image_->buf[row * image_->stride + column] > 127 ? kPaper : kInk;
  }

 private:
  TagFamily family_;
  std::unique_ptr<image_u8_t, void (*)(image_u8_t*)> image_;
  double cell_m_;
};

bool facesCamera(const Pose3& T_camera_tag) {
  // The tag's z axis points into the tag, away from whoever can read it.
  return T_camera_tag.R.col(2).dot(T_camera_tag.t.normalized()) > 0.1;
}

/// Mean brightness over the pixel's area; negative when none of it is on the sheet.
double renderPixel(const CameraModel& camera, const Pose3& T_tag_camera, const Sheet& sheet, int u,
                   int v, double behind) {
  double sum = 0.0;
  bool touched = false;
  for (int k = 0; k < kSamplesPerSide * kSamplesPerSide; ++k) {
    const double du = (k % kSamplesPerSide + 0.5) / kSamplesPerSide - 0.5;
    const double dv = (k / kSamplesPerSide + 0.5) / kSamplesPerSide - 0.5;
    double value = -1.0;
    if (const auto ray = bearing(camera, Vector2(u + du, v + dv))) {
      const Vector3 d = T_tag_camera.R * *ray;
      const double s = -T_tag_camera.t.z() / d.z();
      const Vector3 hit = T_tag_camera.t + s * d;
      if (s > 0.0) value = sheet.at(hit.x(), hit.y());
    }
    touched |= value >= 0.0;
    sum += value >= 0.0 ? value : behind;
  }
  return touched ? sum / (kSamplesPerSide * kSamplesPerSide) : -1.0;
}

/// Pixels the sheet can cover.
cv::Rect boundingBox(const CameraModel& camera, const Pose3& T_camera_tag, double half_side_m) {
  Vector2 low(1e9, 1e9), high(-1e9, -1e9);
  for (const double x : {-half_side_m, half_side_m}) {
    for (const double y : {-half_side_m, half_side_m}) {
      const auto p = project(camera, T_camera_tag * Vector3(x, y, 0.0));
      if (!p) throw std::logic_error("the tag is not in front of the camera");
      low = low.cwiseMin(p->pixel);
      high = high.cwiseMax(p->pixel);
    }
  }
  constexpr int kMargin_px = 8;  // distortion bends the edges
  const cv::Rect box(static_cast<int>(low.x()) - kMargin_px, static_cast<int>(low.y()) - kMargin_px,
                     static_cast<int>(high.x() - low.x()) + 2 * kMargin_px,
                     static_cast<int>(high.y() - low.y()) + 2 * kMargin_px);
  return box & cv::Rect(0, 0, camera.width, camera.height);
}

void drawTag(const TagModel& tag, const std::string& family, const CameraModel& camera,
             const Pose3& T_camera_tag, cv::Mat& image) {
  const Sheet sheet(family, tag.tag_id, tag.size_m);
  const cv::Rect box = boundingBox(camera, T_camera_tag, sheet.halfSide_m());
  const Pose3 T_tag_camera = T_camera_tag.inverse();
  for (int v = box.y; v < box.y + box.height; ++v) {
    for (int u = box.x; u < box.x + box.width; ++u) {
      auto& pixel = image.at<std::uint8_t>(v, u);
      const double value = renderPixel(camera, T_tag_camera, sheet, u, v, pixel);
      if (value >= 0.0) pixel = static_cast<std::uint8_t>(std::lround(value));
    }
  }
}

}  // namespace

CameraModel testCamera(DistortionModel distortion) {
  CameraModel camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = 460.0;
  camera.fy = 459.0;
  camera.cx = 323.4;
  camera.cy = 236.7;
  camera.distortion = distortion;
  if (distortion == DistortionModel::kPlumbBob) {
    camera.coefficients = {-0.28, 0.09, 4e-4, -3e-4, -0.011};
  } else if (distortion == DistortionModel::kKannalaBrandt) {
    camera.fx = camera.fy = 280.0;
    camera.coefficients = {-0.013, 0.021, -0.009, 0.0015};
  }
  return camera;
}

TagModel faceTag(int tag_id, double size_m, const Vector3& centre, const Vector3& outward) {
  TagModel tag;
  tag.tag_id = tag_id;
  tag.size_m = size_m;
  const Vector3 z = -outward.normalized(), y = -Vector3::UnitZ(), x = y.cross(z);
  tag.T_entity_tag.R << x, y, z;
  tag.T_entity_tag.t = centre;
  return tag;
}

EntityModel boxEntity(EntityId id, double half_side_m, double tag_size_m) {
  EntityModel model;
  model.id = id;
  model.name = "box " + std::to_string(id.value);
  model.origin_height_m = half_side_m;
  const std::array<Vector3, 4> normals{Vector3::UnitX(), -Vector3::UnitX(), Vector3::UnitY(),
                                       -Vector3::UnitY()};
  for (int i = 0; i < 4; ++i) {
    const Vector3& n = normals[static_cast<std::size_t>(i)];
    model.tags.push_back(faceTag(i, tag_size_m, half_side_m * n, n));
  }
  return model;
}

Pose3 forwardCamera() {
  Pose3 T_base_camera;
  T_base_camera.R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return T_base_camera;
}

Pose3 uprightAhead(double distance_m, double yaw_rad, double left_m, double down_m) {
  const Pose3 T_base_entity =
      Pose3::fromYawPitchRoll(distance_m, left_m, -down_m, yaw_rad, 0.0, 0.0);
  return forwardCamera().inverse() * T_base_entity;
}

std::vector<TagCornerObservation> visibleCorners(const EntityModel& model,
                                                 const CameraModel& camera,
                                                 const Pose3& T_camera_entity, double sigma_px,
                                                 std::mt19937& generator) {
  std::normal_distribution<double> noise(0.0, 1.0);
  std::vector<TagCornerObservation> visible;
  for (const TagModel& tag : model.tags) {
    if (!facesCamera(T_camera_entity * tag.T_entity_tag)) continue;
    TagCornerObservation observation;
    observation.tag_id = tag.tag_id;
    const auto corners = tag.corners();
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Vector2 error(sigma_px * noise(generator), sigma_px * noise(generator));
      observation.corners_px[i] = project(camera, T_camera_entity * corners[i])->pixel + error;
    }
    visible.push_back(observation);
  }
  return visible;
}

void drawTags(const EntityModel& model, const std::string& family, const CameraModel& camera,
              const Pose3& T_camera_entity, cv::Mat& image) {
  for (const TagModel& tag : model.tags) {
    const Pose3 T_camera_tag = T_camera_entity * tag.T_entity_tag;
    if (facesCamera(T_camera_tag)) drawTag(tag, family, camera, T_camera_tag, image);
  }
}

cv::Mat blankImage(const CameraModel& camera) {
  return cv::Mat(camera.height, camera.width, CV_8UC1, cv::Scalar(kBackground));
}

}  // namespace dynemo::test
