#include <gtest/gtest.h>

#include <numbers>

#include "dynemo/core/error.h"
#include "dynemo/perception/entity_detector.h"
#include "dynemo/perception/perception_params.h"
#include "dynemo/perception/tag_finder.h"
#include "tag_scene.h"

namespace dynemo {
namespace {

using std::numbers::pi;

constexpr double kTranslationTolerance_m = 0.01;
constexpr double kRotationTolerance_rad = 0.02;

CameraImage imageOf(const EntityModel& model, const CameraModel& camera,
                    const Pose3& T_camera_entity, const std::string& family = "tag36h11") {
  CameraImage image;
  image.stamp = Stamp::fromSeconds(100.0);
  image.label = "camera";
  image.model = camera;
  image.T_base_camera = test::forwardCamera();
  image.grey = test::blankImage(camera);
  test::drawTags(model, family, camera, T_camera_entity, image.grey);
  return image;
}

SensorFrame frameOf(CameraImage image) {
  SensorFrame frame;
  frame.stamp = image.stamp;
  frame.images.push_back(std::move(image));
  return frame;
}

void expectNear(const Pose3& expected, const Pose3& actual) {
  const Vector6 error = local(expected, actual);
  EXPECT_LT(error.head<3>().norm(), kTranslationTolerance_m);
  EXPECT_LT(error.tail<3>().norm(), kRotationTolerance_rad);
}

class EveryLensRendered : public ::testing::TestWithParam<DistortionModel> {};

TEST_P(EveryLensRendered, FindsARenderedEntity) {
  const EntityModels models({test::boxEntity(EntityId{5})});
  const CameraModel camera = test::testCamera(GetParam());
  const Pose3 T_camera_entity = test::uprightAhead(1.8, pi + 0.8);
  const auto detector = entityDetectors().make("apriltag", PerceptionParams{}, models);
  const auto observations =
      detector->detect(frameOf(imageOf(models.all()[0], camera, T_camera_entity)));
  ASSERT_EQ(observations.size(), 1U);
  EXPECT_EQ(observations[0].entity, EntityId{5});
  EXPECT_EQ(observations[0].name, "box 5");
  EXPECT_EQ(observations[0].sensor_label, "camera");
  EXPECT_EQ(observations[0].tag_count, 2);
  expectNear(test::forwardCamera() * T_camera_entity, observations[0].T_base_entity);
  EXPECT_TRUE(detector->warnings().empty());
}

INSTANTIATE_TEST_SUITE_P(Lenses, EveryLensRendered,
                         ::testing::Values(DistortionModel::kNone, DistortionModel::kPlumbBob,
                                           DistortionModel::kKannalaBrandt));

class EveryFamily : public ::testing::TestWithParam<std::string> {};

TEST_P(EveryFamily, IsFoundUpright) {
  EntityModel model = test::boxEntity(EntityId{1});
  const CameraModel camera = test::testCamera(DistortionModel::kNone);
  const Pose3 T_camera_entity = test::uprightAhead(1.5, pi + 0.2);
  const EntityModels models({model}, GetParam());
  const auto detector = entityDetectors().make("apriltag", PerceptionParams{}, models);
  const auto observations =
      detector->detect(frameOf(imageOf(model, camera, T_camera_entity, GetParam())));
  ASSERT_EQ(observations.size(), 1U);
  expectNear(test::forwardCamera() * T_camera_entity, observations[0].T_base_entity);
}

INSTANTIATE_TEST_SUITE_P(Families, EveryFamily, ::testing::ValuesIn(tagFamilyNames()),
                         [](const auto& family) { return family.param; });

TEST(AprilTagDetector, AccountsForTheRobotsMotionSinceTheScan) {
  const EntityModels models({test::boxEntity(EntityId{5})});
  const Pose3 T_camera_entity = test::uprightAhead(1.8, pi + 0.5);
  CameraImage image =
      imageOf(models.all()[0], test::testCamera(DistortionModel::kNone), T_camera_entity);
  const Pose3 T_odom_frame = Pose3::fromYawPitchRoll(3.0, -2.0, 0.1, 0.7, 0.01, -0.02);
  const Pose3 T_frame_image = Pose3::fromYawPitchRoll(0.05, 0.01, 0.0, 0.06, 0.0, 0.0);
  image.odometry = OdometryState{T_odom_frame * T_frame_image, std::nullopt};
  SensorFrame frame = frameOf(std::move(image));
  frame.stamp.ns -= 20'000'000;
  frame.odometry = OdometryState{T_odom_frame, std::nullopt};
  const auto detector = entityDetectors().make("apriltag", PerceptionParams{}, models);
  const auto observations = detector->detect(frame);
  ASSERT_EQ(observations.size(), 1U);
  EXPECT_EQ(observations[0].stamp, frame.images[0].stamp);
  expectNear(T_frame_image * test::forwardCamera() * T_camera_entity,
             observations[0].T_base_entity);

  frame.odometry.reset();
  ASSERT_EQ(detector->detect(frame).size(), 1U);
  EXPECT_EQ(detector->warnings().size(), 1U);
}

TEST(AprilTagDetector, CountsTagsThatNoEntityCarries) {
  const EntityModels models({test::boxEntity(EntityId{5})});
  EntityModel stranger = test::boxEntity(EntityId{6});
  for (TagModel& tag : stranger.tags) tag.tag_id += 100;
  const auto detector = entityDetectors().make("apriltag", PerceptionParams{}, models);
  const auto image = imageOf(stranger, test::testCamera(DistortionModel::kNone),
                             test::uprightAhead(1.8, pi + 0.1));
  EXPECT_TRUE(detector->detect(frameOf(image)).empty());
  EXPECT_EQ(detector->warnings().at("unknown tag id"), 1U);
}

TEST(AprilTagDetector, CountsASecondPrintOfATag) {
  const EntityModels models({test::boxEntity(EntityId{5})});
  const CameraModel camera = test::testCamera(DistortionModel::kNone);
  CameraImage image = imageOf(models.all()[0], camera, test::uprightAhead(2.2, pi + 0.1, 0.6));
  test::drawTags(models.all()[0], "tag36h11", camera, test::uprightAhead(2.2, pi - 0.1, -0.6),
                 image.grey);
  const auto detector = entityDetectors().make("apriltag", PerceptionParams{}, models);
  EXPECT_EQ(detector->detect(frameOf(image)).size(), 1U);
  EXPECT_EQ(detector->warnings().at("tag id seen twice in one image"), 1U);
}

TEST(AprilTagDetector, ObservationsComeInOrderOfEntity) {
  EntityModel second = test::boxEntity(EntityId{2});
  for (TagModel& tag : second.tags) tag.tag_id += 10;
  const EntityModels models({test::boxEntity(EntityId{9}), second});
  const CameraModel camera = test::testCamera(DistortionModel::kNone);
  CameraImage image = imageOf(models.all()[0], camera, test::uprightAhead(2.2, pi + 0.3, 0.6));
  test::drawTags(second, "tag36h11", camera, test::uprightAhead(2.2, pi + 0.3, -0.6), image.grey);
  const auto detector = entityDetectors().make("apriltag", PerceptionParams{}, models);
  const auto observations = detector->detect(frameOf(image));
  ASSERT_EQ(observations.size(), 2U);
  EXPECT_EQ(observations[0].entity, EntityId{2});
  EXPECT_EQ(observations[1].entity, EntityId{9});
}

TEST(AprilTagDetector, CountsImagesThatCannotBeUsed) {
  const EntityModels models({test::boxEntity(EntityId{5})});
  const CameraModel camera = test::testCamera(DistortionModel::kNone);
  const CameraImage good = imageOf(models.all()[0], camera, test::uprightAhead(1.8, pi + 0.5));
  const auto detector = entityDetectors().make("apriltag", PerceptionParams{}, models);
  CameraImage empty = good, uncalibrated = good, cropped = good;
  empty.grey = cv::Mat();
  uncalibrated.model = CameraModel{};
  cropped.grey = good.grey(cv::Rect(0, 0, 320, 240)).clone();
  for (const CameraImage& image : {empty, uncalibrated, cropped}) {
    EXPECT_TRUE(detector->detect(frameOf(image)).empty());
  }
  EXPECT_EQ(detector->warnings().size(), 3U);
}

TEST(AprilTagDetector, TheCovarianceHasTheConfiguredFloor) {
  const EntityModels models({test::boxEntity(EntityId{5})});
  PerceptionParams params;
  params.min_sigma_translation_m = 0.2;
  params.min_sigma_rotation_rad = 0.3;
  const auto detector = entityDetectors().make("apriltag", params, models);
  const auto observations =
      detector->detect(frameOf(imageOf(models.all()[0], test::testCamera(DistortionModel::kNone),
                                       test::uprightAhead(1.8, pi + 0.5))));
  ASSERT_EQ(observations.size(), 1U);
  EXPECT_NEAR(observations[0].covariance(0, 0), 0.04, 1e-9);
  EXPECT_NEAR(observations[0].covariance(5, 5), 0.09, 1e-9);
}

TEST(TagFinder, IntegerCoordinatesArePixelCentres) {
  constexpr double kMaxMeanOffset_px = 0.1;
  const EntityModel model = test::boxEntity(EntityId{5});
  const CameraModel camera = test::testCamera(DistortionModel::kPlumbBob);
  TagFinder finder("tag36h11", {});
  Vector2 sum = Vector2::Zero();
  std::size_t count = 0;
  for (const double yaw : {pi - 0.4, pi, pi + 0.5}) {
    const Pose3 T_camera_entity = test::uprightAhead(1.6, yaw);
    cv::Mat image = test::blankImage(camera);
    test::drawTags(model, "tag36h11", camera, T_camera_entity, image);
    std::mt19937 generator(1);
    const auto truth = test::visibleCorners(model, camera, T_camera_entity, 0.0, generator);
    for (const FoundTag& found : finder.find(image)) {
      for (const TagCornerObservation& tag : truth) {
        if (tag.tag_id != found.observation.tag_id) continue;
        for (std::size_t i = 0; i < 4; ++i, ++count) {
          sum += found.observation.corners_px[i] - tag.corners_px[i];
        }
      }
    }
  }
  ASSERT_GE(count, 12U);
  EXPECT_LT((sum / static_cast<double>(count)).norm(), kMaxMeanOffset_px);
}

TEST(AprilTagDetector, RefusesADecimationThatTheLibraryDoesNotOffer) {
  PerceptionParams params;
  params.tag_finder.decimate = 2.5;
  const EntityModels models;
  EXPECT_THROW(entityDetectors().make("apriltag", params, models), ConfigError);
}

}  // namespace
}  // namespace dynemo
