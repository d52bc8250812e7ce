// The detector's poses of rendered tags against the truth.
#include "dynemo/simulation/camera.h"

#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "dynemo/perception/entity_detector.h"
#include "dynemo/perception/perception_params.h"
#include "dynemo/simulation/simulation.h"
#include "small_world.h"

namespace dynemo::simulation::test {
namespace {

CameraModel modelOf(const CameraSpec& spec) {
  CameraModel model;
  model.width = spec.width;
  model.height = spec.height;
  model.fx = spec.fx;
  model.fy = spec.fy;
  model.cx = spec.cx;
  model.cy = spec.cy;
  model.distortion = DistortionModel::kPlumbBob;
  std::copy(spec.distortion.begin(), spec.distortion.end(), model.coefficients.begin());
  return model;
}

/// A robot that drives towards boxes at several distances, seen through a distorting lens.
World gallery() {
  World world = smallWorld();
  world.storeys[0].outline = {0, -4, 14, 4};
  world.storeys[0].walls.clear();
  world.storeys[0].furniture.clear();
  world.relocations.clear();
  world.entities.clear();
  // None hides another one.
  const std::array<double, 8> distance_m{2.5, 3.2, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0};
  const std::array<double, 8> bearing_rad{-0.42, 0.40, -0.12, 0.14, 0.0, -0.24, 0.24, 0.08};
  for (std::size_t i = 0; i < distance_m.size(); ++i) {
    const int id = static_cast<int>(i) + 1;
    Entity box;
    box.id = id;
    box.model = "box";
    box.size = Vector3(0.5, 0.5, 0.5);
    box.at = {0.7 + distance_m[i], distance_m[i] * std::tan(bearing_rad[i])};
    box.yaw_rad = 3.0 + 0.1 * id;
    box.tag_ids = {4 * id, 4 * id + 1, 4 * id + 2, 4 * id + 3};
    world.entities.push_back(box);
  }
  world.robot.route = {{{0.5, 0, 0}, 0}, {{2.0, 0, 0}, 0}};
  world.sensors.camera = CameraSpec();
  world.sensors.camera.distortion = {0.08, -0.18, 0.0006, -0.0004, 0.05};
  return world;
}

struct Error {
  double distance_m, size;
};

double median(std::vector<Error> errors, double from_m, double to_m, std::size_t at_least) {
  std::erase_if(errors,
                [&](const Error& e) { return e.distance_m < from_m || e.distance_m >= to_m; });
  EXPECT_GE(errors.size(), at_least) << "between " << from_m << " and " << to_m << " m";
  if (errors.empty()) return 1e9;
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  std::nth_element(errors.begin(), middle, errors.end(),
                   [](const Error& a, const Error& b) { return a.size < b.size; });
  return middle->size;
}

cv::Mat greyImage(Camera& camera, std::uint64_t index, double t_s) {
  cv::Mat grey;
  cv::cvtColor(camera.image(index, t_s), grey, cv::COLOR_BGR2GRAY);
  return grey;
}

/// Position errors of the boxes that the project's own detector finds in the images of a drive [m].
std::vector<Error> poseErrors(const World& world) {
  const Scene scene(world);
  TemporaryFolder folder;
  World moment = world;
  moment.duration_s = 0.1;
  simulate(moment, folder.path(), 1, [](double) { return true; });
  const EntityModels models = EntityModels::load(folder.path() / "small_entities.yaml");
  const PerceptionParams params;
  const auto detector = entityDetectors().make("apriltag", params, models);
  Camera camera(scene);
  std::vector<Error> errors;
  for (std::uint64_t i = 0; i < 10; ++i) {
    const double t_s = 0.2 * static_cast<double>(i);
    SensorFrame frame;
    CameraImage image;
    image.grey = greyImage(camera, i, t_s);
    image.model = modelOf(world.sensors.camera);
    image.T_base_camera = T_base_camera(world.sensors.camera);
    frame.images.push_back(image);
    for (const EntityObservation& found : detector->detect(frame)) {
      const auto at = static_cast<std::size_t>(found.entity.value - 1);
      const Pose3 T_base_entity = scene.robot().at(t_s).inverse() * scene.entities()[at].at(t_s);
      const double distance_m = (image.T_base_camera.inverse() * T_base_entity).t.norm();
      errors.push_back({distance_m, (found.T_base_entity.t - T_base_entity.t).norm()});
    }
  }
  return errors;
}

/// Corners of one tag where OpenCV's own projection puts them, in the order of
/// apriltag_detection_t::p.
std::vector<cv::Point2d> trueCorners(const Pose3& T_camera_tag, double size_m,
                                     const CameraSpec& spec) {
  const double h = 0.5 * size_m;
  std::vector<cv::Point3d> points;
  for (const Vector3& c :
       {Vector3(-h, h, 0), Vector3(h, h, 0), Vector3(h, -h, 0), Vector3(-h, -h, 0)}) {
    const Vector3 p = T_camera_tag * c;
    points.emplace_back(p.x(), p.y(), p.z());
  }
  std::vector<cv::Point2d> pixels;
  cv::projectPoints(points, cv::Vec3d(), cv::Vec3d(),
                    cv::Matx33d(spec.fx, 0, spec.cx, 0, spec.fy, spec.cy, 0, 0, 1), spec.distortion,
                    pixels);
  return pixels;
}

/// RMS corner errors of the tags that libapriltag finds in one image [px]; `expected` counts those
/// that face the camera by less than 60° and are in the image.
std::vector<Error> cornerErrors(const Scene& scene, double t_s, std::size_t& expected) {
  const CameraSpec& spec = scene.world().sensors.camera;
  Camera camera(scene);
  cv::Mat grey = greyImage(camera, 0, t_s);
  apriltag_family_t* family = tag36h11_create();
  apriltag_detector_t* detector = apriltag_detector_create();
  apriltag_detector_add_family(detector, family);
  detector->quad_decimate = 1.0f;
  image_u8_t view{grey.cols, grey.rows, static_cast<std::int32_t>(grey.step), grey.data};
  zarray_t* found = apriltag_detector_detect(detector, &view);
  std::vector<Error> errors;
  const Pose3 T_camera_world = (scene.robot().at(t_s) * T_base_camera(spec)).inverse();
  for (std::size_t i = 0; i < scene.entities().size(); ++i) {
    for (const TagSheet& tag : scene.bodies()[i + 1].tags) {
      const Pose3 T_camera_tag = T_camera_world * scene.entities()[i].at(t_s) * tag.T_body_tag;
      if (T_camera_tag.R.col(2).dot(T_camera_tag.t.normalized()) < 0.5) continue;
      const auto truth = trueCorners(T_camera_tag, tag.size_m, spec);
      const bool inside = std::all_of(truth.begin(), truth.end(), [&](const cv::Point2d& p) {
        return p.x > 15 && p.y > 15 && p.x < spec.width - 15 && p.y < spec.height - 15;
      });
      expected += inside;
      for (int k = 0; k < zarray_size(found); ++k) {
        apriltag_detection_t* detection = nullptr;
        zarray_get(found, k, &detection);
        if (detection->id != tag.tag_id) continue;
        double squares = 0.0;
        for (std::size_t c = 0; c < 4; ++c) {
          squares += std::pow(detection->p[c][0] - 0.5 - truth[c].x, 2) +
                     std::pow(detection->p[c][1] - 0.5 - truth[c].y, 2);
        }
        errors.push_back({T_camera_tag.t.norm(), std::sqrt(squares / 4)});
      }
    }
  }
  apriltag_detections_destroy(found);
  apriltag_detector_destroy(detector);
  tag36h11_destroy(family);
  return errors;
}

TEST(CameraImage, LibapriltagFindsTheTagsWhereTheyAre) {
  const Scene scene(gallery());
  std::size_t expected = 0;
  const auto errors = cornerErrors(scene, 0.0, expected);
  EXPECT_GE(expected, 8u);
  EXPECT_GE(errors.size() + 2, expected);
  EXPECT_LE(median(errors, 1.0, 5.0, 3), 0.2);
  EXPECT_LE(median(errors, 5.0, 10.0, 3), 0.25);
}

TEST(CameraImage, DetectedPosesAreRightToMillimetres) {
  EXPECT_LE(median(poseErrors(gallery()), 2.0, 3.5, 8), 0.005);
  World quiet = gallery();
  quiet.sensors.noise = false;
  EXPECT_LE(median(poseErrors(quiet), 2.0, 3.5, 8), 0.004);
}

TEST(CameraImage, DependsOnTimeAndIndexOnly) {
  const Scene scene(smallWorld());
  Camera a(scene), b(scene);
  const cv::Mat first = a.image(3, 1.0).clone();
  a.image(4, 2.0);
  EXPECT_EQ(cv::norm(first, b.image(3, 1.0), cv::NORM_INF), 0.0);
  EXPECT_GT(cv::norm(first, b.image(4, 1.0), cv::NORM_INF), 0.0) << "the noise is another one";
  EXPECT_EQ(cv::norm(first, a.image(3, 1.0), cv::NORM_INF), 0.0);
}

}  // namespace
}  // namespace dynemo::simulation::test
