#include <gtest/gtest.h>

#include "dynemo/core/error.h"
#include "dynemo/core/noise.h"
#include "dynemo/perception/entity_detector.h"
#include "dynemo/perception/perception_params.h"
#include "tag_scene.h"

namespace dynemo {
namespace {

constexpr double kTolerance = 1e-12;

ExternalDetection detectionOf(std::int64_t id, const std::string& class_name) {
  ExternalDetection detection;
  detection.stamp = Stamp::fromSeconds(50.0);
  detection.entity = EntityId{id};
  detection.class_name = class_name;
  detection.T_base_entity = Pose3::fromYawPitchRoll(2.0, 1.0, 0.3, 0.4, 0.0, 0.0);
  detection.sensor_label = "radar";
  return detection;
}

class ExternalDetector : public ::testing::Test {
 protected:
  std::vector<EntityObservation> detect(std::vector<ExternalDetection> detections) {
    SensorFrame frame;
    frame.stamp = Stamp::fromSeconds(50.0);
    frame.detections = std::move(detections);
    return detector_->detect(frame);
  }
  EntityModels models_{{test::boxEntity(EntityId{5})}};
  PerceptionParams params_;
  std::unique_ptr<EntityDetector> detector_ = entityDetectors().make("external", params_, models_);
};

TEST_F(ExternalDetector, TakesClassAndNameFromTheEntityFile) {
  const auto observations = detect({detectionOf(5, "")});
  ASSERT_EQ(observations.size(), 1U);
  EXPECT_EQ(observations[0].name, "box 5");
  EXPECT_EQ(observations[0].semantic_class, SemanticClass::kObject);
  EXPECT_EQ(observations[0].sensor_label, "radar");
  EXPECT_TRUE(detector_->warnings().empty());
}

TEST_F(ExternalDetector, TheEntityFileOverridesAnotherClass) {
  const auto observations = detect({detectionOf(5, "agent")});
  ASSERT_EQ(observations.size(), 1U);
  EXPECT_EQ(observations[0].semantic_class, SemanticClass::kObject);
  EXPECT_EQ(detector_->warnings().size(), 1U);
}

TEST_F(ExternalDetector, AnUnlistedEntityNeedsAClass) {
  const auto observations = detect({detectionOf(8, "agent"), detectionOf(9, "")});
  ASSERT_EQ(observations.size(), 1U);
  EXPECT_EQ(observations[0].entity, EntityId{8});
  EXPECT_EQ(observations[0].semantic_class, SemanticClass::kAgent);
  EXPECT_EQ(observations[0].name, "agent 8");
  EXPECT_EQ(detector_->warnings().at(kUnknownEntityWarning), 1U);
}

TEST_F(ExternalDetector, AnUnknownClassIsCounted) {
  EXPECT_TRUE(detect({detectionOf(8, "cat")}).empty());
  EXPECT_EQ(detector_->warnings().at("unknown class 'cat' of an external detection"), 1U);
}

TEST_F(ExternalDetector, KeepsAGivenCovarianceAndReplacesAMissingOrBrokenOne) {
  ExternalDetection with = detectionOf(5, ""), without = with, broken = with;
  with.covariance = isotropicCovariance(0.3, 0.4);
  without.sensor_label = "b";
  broken.sensor_label = "c";
  broken.covariance = -Matrix6::Identity();
  const auto observations = detect({broken, without, with});
  ASSERT_EQ(observations.size(), 3U);
  const Matrix6 by_default = isotropicCovariance(params_.external.default_sigma_translation_m,
                                                 params_.external.default_sigma_rotation_rad);
  EXPECT_LT((observations[0].covariance - by_default).norm(), kTolerance);
  EXPECT_LT((observations[1].covariance - by_default).norm(), kTolerance);
  EXPECT_LT((observations[2].covariance - *with.covariance).norm(), kTolerance);
  EXPECT_EQ(detector_->warnings().size(), 1U);
}

TEST_F(ExternalDetector, AccountsForTheRobotsMotion) {
  ExternalDetection detection = detectionOf(5, "");
  detection.stamp.ns += 30'000'000;
  const Pose3 T_odom_frame = Pose3::fromYawPitchRoll(1.0, 2.0, 0.0, 0.5, 0.0, 0.0);
  const Pose3 T_frame_detection = Pose3::fromYawPitchRoll(0.03, 0.0, 0.0, 0.04, 0.0, 0.0);
  detection.odometry = OdometryState{T_odom_frame * T_frame_detection, std::nullopt};
  SensorFrame frame;
  frame.stamp = Stamp::fromSeconds(50.0);
  frame.odometry = OdometryState{T_odom_frame, std::nullopt};
  frame.detections = {detection};
  const auto observations = detector_->detect(frame);
  ASSERT_EQ(observations.size(), 1U);
  EXPECT_LT(
      local(T_frame_detection * detection.T_base_entity, observations[0].T_base_entity).norm(),
      kTolerance);
  EXPECT_EQ(observations[0].stamp, detection.stamp);
}

TEST_F(ExternalDetector, LeavesOutWhatIsNotFiniteOrRepeated) {
  ExternalDetection broken = detectionOf(5, "");
  broken.T_base_entity.t.x() = NAN;
  const auto observations = detect({broken, detectionOf(5, ""), detectionOf(5, "")});
  EXPECT_EQ(observations.size(), 1U);
  EXPECT_EQ(detector_->warnings().size(), 2U);
}

TEST(DetectorRegistry, KnowsBothAndNamesThemOnError) {
  const EntityModels models;
  EXPECT_EQ(entityDetectors().names(), (std::vector<std::string>{"apriltag", "external"}));
  EXPECT_THROW(entityDetectors().make("sonar", PerceptionParams{}, models), ConfigError);
}

}  // namespace
}  // namespace dynemo
