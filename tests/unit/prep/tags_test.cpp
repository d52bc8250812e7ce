// Logs with tags drawn into the images: survey, draft of an entity file, annotation, export.
#include <gtest/gtest.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservation6DFeatures.h>
#include <mrpt/obs/CObservationImage.h>

#include <cmath>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "dynemo/core/error.h"
#include "dynemo/core/mrpt_conversions.h"
#include "dynemo/ingest/rawlog_source.h"
#include "dynemo/perception/entity_detector.h"
#include "dynemo/prep/annotate.h"
#include "dynemo/prep/inspection.h"
#include "dynemo/prep/kitti_export.h"
#include "generated_rawlog.h"
#include "tag_scene.h"
#include "written_log.h"

namespace dynemo::test {
namespace {

constexpr double kTagSize_m = 0.28;

/// A still robot that sees a still box (entity 1, tags 0–3) and one that is carried past (entity 2,
/// tags 10–13), with LiDAR points on the faces of both.
class Tags : public ::testing::Test {
 protected:
  static Pose3 boxPose(double) { return uprightAhead(3.0, 0.0, 0.8); }
  static Pose3 walkerPose(double t) { return uprightAhead(3.5, 0.0, -0.8 + 0.6 * t); }

  void SetUp() override { writeLog(); }

  void writeLog() {
    EntityModel box = boxEntity(EntityId{1}), walker = boxEntity(EntityId{2});
    for (TagModel& tag : walker.tags) tag.tag_id += 10;
    walker.semantic_class = SemanticClass::kAgent;
    models = EntityModels({box, walker});
    RawlogWriter out(log, true);
    for (int i = 0; i < 15; ++i) {
      const double t = 0.1 * i;
      out.write(scan(t));
      out.write(image(t));
      auto pose = poseObservation(t);
      pose.pose.mean = {};
      out.write(pose);
    }
  }

  mrpt::obs::CObservationImage image(double t) const {
    cv::Mat pixels = blankImage(camera);
    drawTags(models.all()[0], "tag36h11", camera, boxPose(t), pixels);
    drawTags(models.all()[1], "tag36h11", camera, walkerPose(t), pixels);
    auto o = imageObservation(t);
    o.image = mrpt::img::CImage(pixels, mrpt::img::DEEP_COPY);
    o.cameraParams.ncols = static_cast<std::uint32_t>(camera.width);
    o.cameraParams.nrows = static_cast<std::uint32_t>(camera.height);
    o.cameraParams.setIntrinsicParamsFromValues(camera.fx, camera.fy, camera.cx, camera.cy);
    using mrpt::img::DistortionModel;
    o.cameraParams.distortion =
        camera.distortion == dynemo::DistortionModel::kNone       ? DistortionModel::none
        : camera.distortion == dynemo::DistortionModel::kPlumbBob ? DistortionModel::plumb_bob
                                                                  : DistortionModel::kannala_brandt;
    std::copy(camera.coefficients.begin(), camera.coefficients.end(), o.cameraParams.dist.begin());
    o.cameraPose = toMrpt(forwardCamera());
    return o;
  }

  /// Points on the back faces, which is where tags 1 and 11 sit.
  mrpt::obs::CObservationPointCloud scan(double t) const {
    auto o = cloudObservation(t, 1);
    auto map = mrpt::maps::CSimplePointsMap::Create();
    for (const Pose3& T_camera_entity : {boxPose(t), walkerPose(t)})
      for (double y = -0.2; y <= 0.2; y += 0.05)
        for (double z = -0.2; z <= 0.2; z += 0.05) {
          const Vector3 p = kBaseFromLidar.inverse() *
                            (forwardCamera() * (T_camera_entity * Vector3(-0.25, y, z)));
          map->insertPoint(static_cast<float>(p.x()), static_cast<float>(p.y()),
                           static_cast<float>(p.z()));
        }
    o.pointcloud = map;
    return o;
  }

  TagSurvey survey(const TagSurveyParams& params) const {
    TagSurvey result(params);
    const auto source = makeRawlogSource({}, log);
    while (const auto frame = source->next()) result.add(*frame);
    return result;
  }
  static SurveyedTag tag(const TagSurvey& survey, int id) {
    for (const auto& t : survey.tags())
      if (t.id == id) return t;
    throw std::out_of_range("tag");
  }

  TemporaryFolder folder;
  fs::path log = folder / "log.rawlog";
  CameraModel camera = testCamera(DistortionModel::kNone);
  EntityModels models;
};

TEST_F(Tags, SizesAndMotionAreMeasured) {
  const TagSurvey result = survey({});
  EXPECT_EQ(result.imagesSearched(), 15U);
  const auto still = tag(result, 1), moving = tag(result, 11);
  EXPECT_EQ(still.sightings, 15);
  ASSERT_TRUE(still.measured_size_m && moving.measured_size_m);
  EXPECT_NEAR(*still.measured_size_m, kTagSize_m, 0.005);
  EXPECT_NEAR(*moving.measured_size_m, kTagSize_m, 0.005);
  EXPECT_LT(*still.speed_m_s, 0.1);
  EXPECT_NEAR(*moving.speed_m_s, 0.6, 0.1);
}

TEST_F(Tags, TheDraftIsAnEntityFile) {
  const TagSurveyParams params;
  writeFile(folder / "entities.yaml", entityFileDraft(survey(params), params, 3, "log.rawlog"));
  const auto draft = EntityModels::load(folder / "entities.yaml");
  const auto [still, still_tag] = draft.findTag(1);
  const auto [moving, moving_tag] = draft.findTag(11);
  ASSERT_TRUE(still && moving);
  EXPECT_EQ(still->semantic_class, SemanticClass::kObject);
  EXPECT_EQ(moving->semantic_class, SemanticClass::kAgent);
  EXPECT_NEAR(still_tag->size_m, kTagSize_m, 0.005);
  // The tag faces forward: into the tag is backwards, its right is the entity's left.
  EXPECT_LT((still_tag->T_entity_tag.R.col(2) - Vector3(-1, 0, 0)).norm(), 1e-9);
  EXPECT_LT((still_tag->T_entity_tag.R.col(0) - Vector3(0, 1, 0)).norm(), 1e-9);
}

TEST_F(Tags, AGivenSizeIsTakenAndRareTagsAreLeftOut) {
  const TagSurveyParams params{.size_m = 0.1};
  writeFile(folder / "entities.yaml", entityFileDraft(survey(params), params, 16, "log"));
  EXPECT_TRUE(EntityModels::load(folder / "entities.yaml").empty());
  writeFile(folder / "entities.yaml", entityFileDraft(survey(params), params, 15, "log"));
  const auto draft = EntityModels::load(folder / "entities.yaml");
  ASSERT_NE(draft.findTag(1).second, nullptr);
  EXPECT_EQ(draft.findTag(1).second->size_m, 0.1);
}

TEST_F(Tags, WithoutLidarTheSizeMustBeGiven) {
  decimateRawlog(log, folder / "x.rawlog", {.labels = {"lidar"}, .keep_every = 1000}, {});
  trimRawlog(folder / "x.rawlog", folder / "y.rawlog", {.from_s = 0.05, .to_s = {}}, {});
  TagSurvey result({});
  const auto source = makeRawlogSource({}, folder / "y.rawlog");
  while (const auto frame = source->next()) result.add(*frame);
  ASSERT_FALSE(result.tags().empty());
  EXPECT_THROW(entityFileDraft(result, {}, 1, "y"), ConfigError);
}

TEST_F(Tags, CheckListsThem) {
  const auto inspection = inspectRawlog(log, {});
  EXPECT_EQ(inspection.images_searched, 15U);
  std::vector<int> ids;
  for (const auto& t : inspection.tags) ids.push_back(t.id);
  EXPECT_EQ(ids, (std::vector<int>{1, 11}));
  InspectionParams few;
  few.tag_images = 5;
  EXPECT_EQ(inspectRawlog(log, few).images_searched, 5U);
}

TEST_F(Tags, AnnotatedLogsGiveTheSameObservationsWithoutImages) {
  const auto report = annotateRawlog(log, folder / "out.rawlog", models, {.drop_images = true}, {});
  EXPECT_EQ(report.images, 15U);
  EXPECT_EQ(report.detections, 30U);
  EXPECT_EQ(countByLabel(readLog(folder / "out.rawlog")),
            (std::map<std::string, int>{{"lidar", 15}, {"camera_entities", 15}, {"odom3d", 15}}));

  const auto detectWith = [&](const char* detector, const fs::path& rawlog) {
    std::vector<EntityObservation> all;
    const auto d = entityDetectors().make(detector, PerceptionParams(), models);
    const auto source = makeRawlogSource({}, rawlog);
    while (const auto frame = source->next())
      for (auto& o : d->detect(*frame)) all.push_back(std::move(o));
    return all;
  };
  const auto seen = detectWith("apriltag", log);
  const auto stored = detectWith("external", folder / "out.rawlog");
  ASSERT_EQ(seen.size(), 30U);
  ASSERT_EQ(stored.size(), seen.size());
  for (std::size_t i = 0; i < seen.size(); ++i) {
    EXPECT_EQ(stored[i].entity, seen[i].entity);
    EXPECT_EQ(stored[i].stamp, seen[i].stamp);
    EXPECT_LT(local(seen[i].T_base_entity, stored[i].T_base_entity).norm(), 1e-6);
    EXPECT_LT((stored[i].covariance - seen[i].covariance).norm(), 1e-3 * seen[i].covariance.norm());
  }
}

TEST_F(Tags, AnnotationKeepsTheRestByteByByte) {
  annotateRawlog(log, folder / "out.rawlog", models, {}, {});
  const auto before = readLog(log);
  auto after = readLog(folder / "out.rawlog");
  std::erase_if(after, [](const auto& o) { return o.label == "camera_entities"; });
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < after.size(); ++i) EXPECT_EQ(after[i].bytes, before[i].bytes);
}

TEST_F(Tags, ExportWritesOneOfEachPerFrame) {
  const auto report = exportKitti(log, folder / "kitti", {});
  EXPECT_EQ(report.clouds, 15U);
  EXPECT_EQ(report.images, 15U);
  EXPECT_EQ(report.poses, 15U);
  EXPECT_EQ(filesIn(folder / "kitti"),
            (std::vector<std::string>{"calib.txt", "calib_cam_to_cam.txt", "image_0", "poses.txt",
                                      "stamps.txt", "times.txt", "velodyne"}));
  EXPECT_EQ(report.rectified, 0U);
  EXPECT_EQ(report.warnings.size(), 0U);
  const auto original = scan(0.0);
  EXPECT_EQ(fs::file_size(folder / "kitti" / "velodyne" / "000000.bin"),
            original.pointcloud->size() * 4 * sizeof(float));
  const cv::Mat pixels =
      cv::imread((folder / "kitti" / "image_0" / "000003.png").string(), cv::IMREAD_UNCHANGED);
  EXPECT_EQ(cv::norm(pixels, image(0.3).image.asCvMat<cv::Mat>(mrpt::img::DEEP_COPY), cv::NORM_INF),
            0.0);
  std::ifstream stamps(folder / "kitti" / "stamps.txt");
  std::string first, second;
  stamps >> first >> second;
  EXPECT_EQ(first, at(0.0).text());
  EXPECT_EQ(second, at(0.1).text());
  // Tr takes LiDAR points to the camera.
  std::ifstream calibration(folder / "kitti" / "calib.txt");
  std::string word;
  double fx = 0;
  calibration >> word >> fx;
  EXPECT_EQ(word, "P0:");
  EXPECT_NEAR(fx, camera.fx, 1e-6);
  while (calibration >> word && word != "Tr:") {
  }
  Eigen::Matrix<double, 3, 4> Tr;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) calibration >> Tr(r, c);
  const Pose3 expected = forwardCamera().inverse() * kBaseFromLidar;
  EXPECT_LT((Tr.leftCols<3>() - expected.R).norm() + (Tr.col(3) - expected.t).norm(), 1e-6);
  EXPECT_THROW(exportKitti(log, folder / "kitti", {}), DataError);
}

TEST_F(Tags, ExportTakesTheLensOutOfTheImages) {
  const auto exported = [&](const char* name) {
    return cv::imread((folder / name / "image_0" / "000003.png").string(), cv::IMREAD_UNCHANGED);
  };
  const auto difference = [](const cv::Mat& a, const cv::Mat& b) {
    return cv::norm(a, b, cv::NORM_L1) / static_cast<double>(a.total());
  };
  const cv::Mat pinhole = image(0.3).image.asCvMat<cv::Mat>(mrpt::img::DEEP_COPY);
  for (const auto lens : {DistortionModel::kPlumbBob, DistortionModel::kKannalaBrandt}) {
    const CameraModel before = camera;
    camera = testCamera(lens);
    camera.fx = before.fx, camera.fy = before.fy, camera.cx = before.cx, camera.cy = before.cy;
    fs::remove(log);
    writeLog();
    fs::remove_all(folder / "rectified");
    fs::remove_all(folder / "recorded");
    const auto rectified = exportKitti(log, folder / "rectified", {});
    const auto recorded = exportKitti(log, folder / "recorded", {}, KittiImages::kAsRecorded);
    EXPECT_EQ(rectified.rectified, 15U);
    EXPECT_EQ(recorded.rectified, 0U);
    EXPECT_EQ(
        recorded.warnings.at("image with lens distortion, which only calib_cam_to_cam.txt tells"),
        15U);
    EXPECT_GT(difference(exported("recorded"), pinhole), 0.5) << "a lens that does something";
    EXPECT_LT(difference(exported("rectified"), pinhole),
              0.35 * difference(exported("recorded"), pinhole));
    std::ifstream file(folder / "recorded" / "calib_cam_to_cam.txt");
    std::string word;
    double k1 = 0, k2 = 0;
    while (file >> word && word != "D_00:") {
    }
    file >> k1 >> k2;
    EXPECT_NEAR(k1, camera.coefficients[0], 1e-6);
    EXPECT_NEAR(k2, camera.coefficients[1], 1e-6);
    camera = before;
  }
}

TEST_F(Tags, ExportWithoutOdometrySaysThatThereAreNoPoses) {
  {
    RawlogWriter out(folder / "bare.rawlog");
    for (int i = 0; i < 5; ++i) out.write(scan(0.1 * i));
  }
  const auto report = exportKitti(folder / "bare.rawlog", folder / "kitti", {});
  EXPECT_EQ(
      report.warnings,
      (std::map<std::string, std::uint64_t>{{"frame without odometry: there is no poses.txt", 5}}));
  EXPECT_FALSE(fs::exists(folder / "kitti" / "poses.txt"));
}

}  // namespace
}  // namespace dynemo::test
