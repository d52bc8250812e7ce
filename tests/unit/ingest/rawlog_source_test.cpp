// From files to frames: formats, sensors, synchronisation and what is reported.
#include "dynemo/ingest/rawlog_source.h"

#include <gtest/gtest.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CActionRobotMovement3D.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPosePDFGaussian.h>

#include "dynemo/core/error.h"
#include "dynemo/core/mrpt_conversions.h"
#include "dynemo/core/noise.h"
#include "generated_rawlog.h"

namespace dynemo {
namespace {

using namespace test;  // NOLINT

constexpr double kPoseTolerance = 1e-9;
/// Between samples on a circle, chord against arc.
constexpr double kInterpolationTolerance = 1e-3;

class RawlogSource : public ::testing::Test {
 protected:
  TemporaryFolder folder_;
  const fs::path log_ = folder_ / "log.rawlog";
  IngestParams params_;

  RawlogWriter& open(bool compressed = false) {
    writer_ = std::make_unique<RawlogWriter>(log_, compressed);
    return *writer_;
  }
  std::vector<SensorFrame> frames() {
    writer_.reset();
    source_ = makeRawlogSource(params_, log_);
    return allFrames(*source_);
  }
  std::unique_ptr<RawlogWriter> writer_;
  std::unique_ptr<FrameSource> source_;
};

void expectNear(const Pose3& expected, const Pose3& actual, double tolerance) {
  EXPECT_LT(local(expected, actual).norm(), tolerance);
}

TEST_F(RawlogSource, ReadsPlainAndCompressedAlike) {
  writeLog(log_, {});
  const auto plain = frames();
  writeLog(log_, {.compressed = true});
  const auto compressed = frames();
  ASSERT_EQ(plain.size(), 51U);
  ASSERT_EQ(compressed.size(), plain.size());
  for (std::size_t i = 0; i < plain.size(); ++i) {
    EXPECT_EQ(plain[i].index, i);
    EXPECT_EQ(plain[i].stamp, at(0.1 * static_cast<double>(i)));
    EXPECT_EQ(compressed[i].stamp, plain[i].stamp);
    EXPECT_EQ(compressed[i].scan->cloud.points, plain[i].scan->cloud.points);
    EXPECT_EQ(plain[i].images.size(), 1U);
  }
  EXPECT_EQ(source_->report().frames, 51U);
  EXPECT_TRUE(source_->report().warnings.empty());
  EXPECT_EQ(source_->report().observations.at("odom3d (CObservationRobotPose)"), 101U);
  EXPECT_EQ(source_->progress().fraction, 1.0);
  EXPECT_NEAR(source_->progress().dataset_s, 5.0, 1e-9);
}

TEST_F(RawlogSource, InterpolatesOdometryToEveryStamp) {
  RawlogWriter& out = open();
  for (int i = 0; i <= 40; ++i) {
    const double t = 0.05 * i;
    out.write(poseObservation(t));
    if (i % 4 == 1) out.write(cloudObservation(t + 0.013));
    if (i % 4 == 1) out.write(imageObservation(t + 0.026));
  }
  out.write(poseObservation(2.05));
  const auto all = frames();
  ASSERT_EQ(all.size(), 10U);
  for (const SensorFrame& f : all) {
    ASSERT_TRUE(f.odometry);
    const double t = secondsBetween(at(0), f.stamp);
    expectNear(truePose(t), f.odometry->T_odom_base, kInterpolationTolerance);
    ASSERT_EQ(f.images.size(), 1U);
    EXPECT_NEAR(secondsBetween(f.stamp, f.images[0].stamp), 0.013, 1e-9);
    ASSERT_TRUE(f.images[0].odometry);
    expectNear(truePose(t + 0.013), f.images[0].odometry->T_odom_base, kInterpolationTolerance);
    const double sigma = 0.1 + 0.01 * t;
    EXPECT_NEAR(f.odometry->accumulated_covariance->coeff(0, 0), sigma * sigma, 1e-5);
    expectNear(kBaseFromLidar, f.scan->T_base_lidar, kPoseTolerance);
    expectNear(kBaseFromCamera, f.images[0].T_base_camera, kPoseTolerance);
  }
}

TEST_F(RawlogSource, PrefersThreeDimensionalOdometry) {
  RawlogWriter& out = open();
  for (int i = 0; i < 30; ++i) {
    out.write(odometryObservation(0.1 * i));
    out.write(poseObservation(0.1 * i));
    out.write(cloudObservation(0.1 * i));
  }
  for (const SensorFrame& f : frames()) EXPECT_TRUE(f.odometry->accumulated_covariance);
  params_.odometry.label = "odom2d";
  const auto planar = frames();
  ASSERT_EQ(planar.size(), 30U);
  for (const SensorFrame& f : planar) {
    EXPECT_FALSE(f.odometry->accumulated_covariance);
    EXPECT_EQ(f.odometry->T_odom_base.t.z(), 0.0);
  }
}

TEST_F(RawlogSource, SeveralLidarsNeedAChoice) {
  RawlogWriter& out = open();
  for (int i = 0; i < 30; ++i) {
    out.write(cloudObservation(0.1 * i, 100, "front"));
    out.write(cloudObservation(0.1 * i, 200, "top"));
  }
  try {
    frames();
    FAIL() << "a choice was made";
  } catch (const ConfigError& e) {
    EXPECT_NE(std::string(e.what()).find("'front', 'top'"), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("sensors.lidar.label"), std::string::npos) << e.what();
  }
  params_.lidar.label = "top";
  const auto chosen = frames();
  ASSERT_EQ(chosen.size(), 30U);
  EXPECT_EQ(chosen[7].scan->cloud.size(), 200U);
  EXPECT_EQ(warningCount(source_->report(), "scan of 'front' not used"), 30U);
}

TEST_F(RawlogSource, SeveralOdometriesNeedAChoice) {
  RawlogWriter& out = open();
  for (int i = 0; i < 30; ++i) {
    out.write(poseObservation(0.1 * i, "icp"));
    out.write(poseObservation(0.1 * i, "visual"));
    out.write(cloudObservation(0.1 * i));
  }
  EXPECT_THROW(frames(), ConfigError);
  params_.odometry.label = "visual";
  EXPECT_EQ(frames().size(), 30U);
}

TEST_F(RawlogSource, UnknownLabelIsAnErrorForTheLidarAndAWarningElsewhere) {
  writeLog(log_, {.duration_s = 1.0});
  params_.cameras.labels = {"camera", "nonesuch"};
  EXPECT_EQ(frames().size(), 11U);
  EXPECT_EQ(warningCount(source_->report(), "configured sensor 'nonesuch'"), 1U);
  params_.lidar.label = "typo";
  try {
    frames();
    FAIL() << "frames without the configured LiDAR";
  } catch (const DataError& e) {
    EXPECT_NE(std::string(e.what()).find("'typo'"), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("lidar (CObservationPointCloud)"), std::string::npos)
        << e.what();
  }
}

TEST_F(RawlogSource, WithoutLidarFramesFollowTheImages) {
  writeLog(log_, {.duration_s = 2.0, .scan_period_s = 0});
  const auto all = frames();
  ASSERT_EQ(all.size(), 21U);
  EXPECT_FALSE(all[3].scan);
  EXPECT_EQ(all[3].images.size(), 1U);
  EXPECT_TRUE(all[3].odometry);
}

TEST_F(RawlogSource, WithoutCameraFramesFollowTheScans) {
  writeLog(log_, {.duration_s = 2.0, .image_period_s = 0});
  const auto all = frames();
  ASSERT_EQ(all.size(), 21U);
  EXPECT_TRUE(all[3].scan);
  EXPECT_TRUE(all[3].images.empty());
}

mrpt::obs::CObservation3DRangeScan depthCamera(double seconds) {
  mrpt::obs::CObservation3DRangeScan o;
  o.timestamp = mrptTime(seconds);
  o.sensorLabel = "rgbd";
  o.sensorPose = toMrpt(kBaseFromLidar);
  o.hasRangeImage = true;
  o.cameraParams.nrows = 4;
  o.cameraParams.ncols = 6;
  o.cameraParams.setIntrinsicParamsFromValues(5, 5, 2.5, 1.5);
  o.rangeImage_setSize(4, 6);
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < 6; ++c) o.rangeImage(r, c) = 2000;
  const auto image = imageObservation(seconds);
  o.hasIntensityImage = true;
  o.intensityImage = image.image;
  o.cameraParamsIntensity = image.cameraParams;
  return o;
}

TEST_F(RawlogSource, ADepthCameraAloneGivesScansAndImages) {
  RawlogWriter& out = open();
  for (int i = 0; i < 5; ++i) out.write(depthCamera(0.1 * i));
  const auto all = frames();
  ASSERT_EQ(all.size(), 5U);
  EXPECT_EQ(all[2].scan->cloud.size(), 24U);
  ASSERT_EQ(all[2].images.size(), 1U);
  EXPECT_EQ(all[2].images[0].model.fx, 60);
  const Pose3 T_depth_optical = Pose3::fromYawPitchRoll(0, 0, 0, -M_PI / 2, 0, -M_PI / 2);
  expectNear(kBaseFromLidar * T_depth_optical, all[2].images[0].T_base_camera, kPoseTolerance);
}

TEST_F(RawlogSource, ACameraGoesBeforeTheImagesOfADepthCamera) {
  RawlogWriter& out = open();
  for (int i = 0; i < 5; ++i) {
    out.write(depthCamera(0.1 * i));
    out.write(imageObservation(0.1 * i));
  }
  for (const SensorFrame& f : frames()) {
    ASSERT_EQ(f.images.size(), 1U);
    EXPECT_EQ(f.images[0].label, "camera");
  }
  params_.cameras.labels = {"camera", "rgbd"};
  for (const SensorFrame& f : frames()) EXPECT_EQ(f.images.size(), 2U);
}

TEST_F(RawlogSource, OdometryAloneGivesFramesToo) {
  writeLog(log_, {.duration_s = 2.0, .scan_period_s = 0, .image_period_s = 0});
  const auto all = frames();
  ASSERT_EQ(all.size(), 41U);
  expectNear(truePose(0.35), all[7].odometry->T_odom_base, kPoseTolerance);
}

TEST_F(RawlogSource, OdometryOfAnotherClockIsNotUsedAndLosesNoScan) {
  for (const double offset_s : {-1.7e9, -3.0, 3.0, 1.7e9}) {
    for (const bool odometry_first : {true, false}) {
      SCOPED_TRACE(std::to_string(offset_s) + (odometry_first ? " first" : " second"));
      {
        RawlogWriter out(log_);
        for (int i = 0; i < 50; ++i) {
          if (odometry_first) out.write(poseObservation(0.1 * i + offset_s));
          out.write(cloudObservation(0.1 * i));
          if (!odometry_first) out.write(poseObservation(0.1 * i + offset_s));
        }
      }
      const auto all = frames();
      EXPECT_FALSE(source_->hasOdometry());
      ASSERT_EQ(all.size(), 50U);
      EXPECT_TRUE(all[7].scan);
      EXPECT_FALSE(all[7].odometry);
      EXPECT_EQ(warningCount(source_->report(), "its clock is not that of the other sensors"), 50U);
    }
  }
}

TEST_F(RawlogSource, OdometryOfTheRightClockIsPreferredToABetterKindOfAnother) {
  RawlogWriter& out = open();
  for (int i = 0; i < 50; ++i) {
    out.write(poseObservation(0.1 * i - 1e6));
    out.write(odometryObservation(0.1 * i));
    out.write(cloudObservation(0.1 * i));
  }
  const auto all = frames();
  EXPECT_TRUE(source_->hasOdometry());
  ASSERT_EQ(all.size(), 50U);
  EXPECT_TRUE(all[7].odometry);
}

TEST_F(RawlogSource, LidarThatStartsAfterTheOdometryIsFound) {
  RawlogWriter& out = open();
  for (int i = 0; i < 200; ++i) {
    out.write(poseObservation(0.05 * i));
    if (i >= 120 && i % 2 == 0) out.write(cloudObservation(0.05 * i));
  }
  const auto all = frames();
  ASSERT_EQ(all.size(), 40U);
  EXPECT_TRUE(all[0].scan);
}

TEST_F(RawlogSource, ObservationsOutOfOrderWithinTheWindowAreSorted) {
  RawlogWriter& out = open();
  for (int i = 0; i < 40; ++i) {
    out.write(imageObservation(0.1 * i));
    if (i >= 3) out.write(cloudObservation(0.1 * (i - 3)));
    if (i >= 2) out.write(poseObservation(0.1 * (i - 2)));
  }
  const auto all = frames();
  ASSERT_EQ(all.size(), 37U);
  for (const SensorFrame& f : all) {
    ASSERT_EQ(f.images.size(), 1U);
    EXPECT_EQ(f.images[0].stamp, f.stamp);
    EXPECT_TRUE(f.odometry);
  }
  EXPECT_EQ(warningCount(source_->report(), "image of 'camera' without a frame"), 3U);
}

TEST_F(RawlogSource, UnmatchedImagesAreCounted) {
  writeLog(log_, {.duration_s = 2.0, .scan_period_s = 0.2, .image_period_s = 0.05});
  const auto all = frames();
  ASSERT_EQ(all.size(), 11U);
  for (const SensorFrame& f : all) {
    ASSERT_EQ(f.images.size(), 1U);
    EXPECT_EQ(f.images[0].stamp, f.stamp);
  }
  EXPECT_EQ(warningCount(source_->report(), "image of 'camera'"), 30U);
}

TEST_F(RawlogSource, LongOdometryGapsAreNotInterpolated) {
  RawlogWriter& out = open();
  for (int i = 0; i <= 60; ++i) {
    const double t = 0.1 * i;
    if (t < 2.0 || t > 4.0) out.write(poseObservation(t));
    out.write(cloudObservation(t));
  }
  const auto all = frames();
  ASSERT_EQ(all.size(), 61U);
  EXPECT_TRUE(all[20].odometry);   // continued from the last sample
  EXPECT_FALSE(all[30].odometry);  // in the middle of the gap
  EXPECT_TRUE(all[50].odometry);
  EXPECT_EQ(warningCount(source_->report(), "frame without odometry at its stamp"), 19U);
}

TEST_F(RawlogSource, ExtrinsicsOfTheConfigurationWin) {
  writeLog(log_, {.duration_s = 1.0});
  params_.extrinsics["lidar"] = {1, 2, 3, 0, 0, 0, 1};
  const auto all = frames();
  expectNear(Pose3::translation(1, 2, 3), all[0].scan->T_base_lidar, kPoseTolerance);
  expectNear(kBaseFromCamera, all[0].images[0].T_base_camera, kPoseTolerance);
}

// Sensory frames.

TEST_F(RawlogSource, AddsUpPlanarOdometryActions) {
  using mrpt::obs::CActionRobotMovement2D;
  RawlogWriter& out = open();
  Pose3 T_odom_base;
  std::vector<Pose3> expected{T_odom_base};
  CActionRobotMovement2D::TMotionModelOptions model;
  for (int i = 0; i <= 20; ++i) {
    if (i > 0) {
      CActionRobotMovement2D action;
      action.computeFromOdometry({0.2, 0.01, 0.05}, model);
      mrpt::obs::CActionCollection actions;
      actions.insert(action);
      out.write(actions);
      T_odom_base = T_odom_base * Pose3::fromYawPitchRoll(0.2, 0.01, 0, 0.05, 0, 0);
      expected.push_back(T_odom_base);
    }
    mrpt::obs::CSensoryFrame frame;
    frame.insert(std::make_shared<mrpt::obs::CObservationPointCloud>(cloudObservation(1.0 * i)));
    out.write(frame);
  }
  const auto all = frames();
  ASSERT_EQ(all.size(), 21U);
  double last_variance = -1;
  for (std::size_t i = 0; i < all.size(); ++i) {
    ASSERT_TRUE(all[i].odometry) << i;
    expectNear(expected[i], all[i].odometry->T_odom_base, kPoseTolerance);
    ASSERT_TRUE(all[i].odometry->accumulated_covariance);
    const double variance = all[i].odometry->accumulated_covariance->trace();
    EXPECT_GT(variance, last_variance);
    last_variance = variance;
  }
}

TEST_F(RawlogSource, AddsUpThreeDimensionalOdometryActions) {
  RawlogWriter& out = open(true);
  const Pose3 step = Pose3::fromYawPitchRoll(0.3, 0.0, 0.02, 0.1, 0.02, -0.01);
  Matrix6 step_cov = isotropicCovariance(0.01, 0.002);
  Pose3 T_odom_base;
  Matrix6 cov = Matrix6::Zero();
  for (int i = 1; i <= 10; ++i) {
    mrpt::obs::CActionRobotMovement3D action;
    action.estimationMethod = mrpt::obs::CActionRobotMovement3D::emOdometry;
    action.poseChange = toMrptGaussian(step, step_cov);
    mrpt::obs::CActionCollection actions;
    actions.insert(action);
    out.write(actions);
    mrpt::obs::CSensoryFrame frame;
    frame.insert(std::make_shared<mrpt::obs::CObservationPointCloud>(cloudObservation(0.1 * i)));
    out.write(frame);
    T_odom_base = T_odom_base * step;
    const Matrix6 A = composeJacobianLeft(step);
    cov = A * cov * A.transpose() + step_cov;
  }
  const auto all = frames();
  ASSERT_EQ(all.size(), 10U);
  expectNear(T_odom_base, all.back().odometry->T_odom_base, 1e-6);
  EXPECT_LT((*all.back().odometry->accumulated_covariance - cov).norm(), 1e-9);
}

TEST_F(RawlogSource, SensoryFramesWithoutActionsHaveNoOdometry) {
  RawlogWriter& out = open();
  for (int i = 0; i < 5; ++i) {
    mrpt::obs::CSensoryFrame frame;
    frame.insert(std::make_shared<mrpt::obs::CObservationPointCloud>(cloudObservation(0.1 * i)));
    out.write(frame);
  }
  const auto all = frames();
  ASSERT_EQ(all.size(), 5U);
  EXPECT_FALSE(all[2].odometry);
}

// Entity detections.

TEST_F(RawlogSource, ReadsFeaturesOfTheLogAsDetections) {
  RawlogWriter& out = open();
  const Pose3 T_sensor_entity = Pose3::fromYawPitchRoll(0.3, -0.2, 4.0, 0.3, 0.2, -0.4);
  const Matrix6 cov = isotropicCovariance(0.03, 0.05);
  for (int i = 0; i < 20; ++i) {
    out.write(cloudObservation(0.1 * i));
    auto features = featuresObservation(0.1 * i + 0.02, 7, T_sensor_entity);
    features.sensedFeatures[0].inf_matrix.asEigen() =
        covarianceToMrpt(T_sensor_entity, cov).asEigen().inverse();
    out.write(features);
  }
  const auto all = frames();
  ASSERT_EQ(all.size(), 20U);
  for (const SensorFrame& f : all) {
    ASSERT_EQ(f.detections.size(), 1U);
    EXPECT_EQ(f.detections[0].entity, EntityId{7});
    EXPECT_NEAR(secondsBetween(f.stamp, f.detections[0].stamp), 0.02, 1e-9);
    expectNear(kBaseFromCamera * T_sensor_entity, f.detections[0].T_base_entity, 1e-6);
    EXPECT_LT((*f.detections[0].covariance - cov).norm(), 1e-8);
  }
}

TEST_F(RawlogSource, JoinsATableOfDetectionsWithTheSensorsOfTheLog) {
  writeLog(log_, {.duration_s = 1.0});
  const Pose3 T_camera_entity = Pose3::translation(0.1, 0.2, 3.0);
  std::string table = "timestamp,entity_id,class,x,y,z,qx,qy,qz,qw,sensor_label\n";
  table += at(0.21).text() + ",5,agent,0.1,0.2,3,0,0,0,1,camera\n";
  table += at(0.22).text() + ",6,object,1,2,3,0,0,0,1\n";
  table += at(0.22).text() + ",8,object,1,2,3,0,0,0,1,nonesuch\n";
  writeFile(folder_ / "detections.csv", table);
  source_ = makeRawlogSource(params_, log_, folder_ / "detections.csv");
  const auto all = allFrames(*source_);
  ASSERT_EQ(all.size(), 11U);
  ASSERT_EQ(all[2].detections.size(), 2U);
  const ExternalDetection& base = all[2].detections[0];  // no label sorts first
  EXPECT_EQ(base.entity, EntityId{6});
  expectNear(Pose3::translation(1, 2, 3), base.T_base_entity, kPoseTolerance);
  const ExternalDetection& seen = all[2].detections[1];
  EXPECT_EQ(seen.class_name, "agent");
  expectNear(kBaseFromCamera * T_camera_entity, seen.T_base_entity, 1e-6);
  ASSERT_TRUE(seen.odometry);
  expectNear(truePose(0.21), seen.odometry->T_odom_base, kInterpolationTolerance);
  EXPECT_EQ(warningCount(source_->report(), "'nonesuch' dropped"), 1U);
}

TEST_F(RawlogSource, ATableOfDetectionsNeedsNoRawlog) {
  std::string table;
  for (int i = 0; i < 4; ++i)
    for (int id : {1, 2})
      table += at(i).text() + "," + std::to_string(id) + ",object,1,2,3,0,0,0,1\n";
  writeFile(folder_ / "detections.csv", table);
  const auto source = makeRawlogSource(params_, std::nullopt, folder_ / "detections.csv");
  const auto all = allFrames(*source);
  ASSERT_EQ(all.size(), 4U);
  EXPECT_EQ(all[1].stamp, at(1));
  EXPECT_EQ(all[1].detections.size(), 2U);
  EXPECT_THROW(makeRawlogSource(params_, std::nullopt), ConfigError);
}

}  // namespace
}  // namespace dynemo
