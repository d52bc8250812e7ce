// The code that the guide to extending shows, at work.
#include <gtest/gtest.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/serialization/CArchive.h>

#include <numbers>
#include <opencv2/imgproc.hpp>

#include "anchored_model.h"
#include "aruco_detector.h"
#include "dynemo/core/error.h"
#include "dynemo/perception/camera_projection.h"
#include "edge_entity_distance.h"
#include "moves_exporter.h"
#include "point_icp.h"
#include "registered_types.h"
#include "scan_pair.h"
#include "small_run.h"
#include "tag_scene.h"

namespace dynemo::test {
namespace {

using std::numbers::pi;

TEST(ExampleExporter, WritesTheMoves) {
  ExporterRegistry r("output");
  r.add("moves", makeMovesExporter);
  const SmallRun run = smallRun();
  const TemporaryFolder folder;
  const auto exporter = r.make("moves", ExportParams());
  exporter->write(run.result(), folder.path() / exporter->fileName());
  const std::string text = readFile(folder.path() / "moves.csv");
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 2) << text;
  EXPECT_NE(text.find("\n7,"), std::string::npos) << text;
  EXPECT_THROW(exporter->write(run.result(), folder.path() / "no" / "moves.csv"), DataError);
}

/// The marker's sheet, with a white border of one cell, as a pinhole camera sees it.
void drawMarker(const TagModel& tag, const CameraModel& camera, const Pose3& T_camera_entity,
                cv::Mat& image) {
  constexpr int kCells = 7, kCell_px = 20, kSheet_px = (kCells + 2) * kCell_px;
  if ((T_camera_entity.R * tag.T_entity_tag.R).col(2).dot(T_camera_entity.t) < 0.0) return;
  cv::Mat marker, sheet(kSheet_px, kSheet_px, CV_8UC1, cv::Scalar(230));
  cv::aruco::drawMarker(cv::aruco::getPredefinedDictionary(cv::aruco::DICT_5X5_250), tag.tag_id,
                        kCells * kCell_px, marker);
  marker.copyTo(sheet(cv::Rect(kCell_px, kCell_px, marker.cols, marker.rows)));
  const double cell_m = tag.size_m / kCells, half_m = 0.5 * cell_m * (kCells + 2);
  const std::array<Vector2, 4> corners_m = {Vector2(-half_m, -half_m), Vector2(half_m, -half_m),
                                            Vector2(half_m, half_m), Vector2(-half_m, half_m)};
  std::vector<cv::Point2f> seen;
  for (const Vector2& c : corners_m) {
    const Vector2 px =
        project(camera, T_camera_entity * tag.T_entity_tag * Vector3(c.x(), c.y(), 0.0))->pixel;
    seen.emplace_back(static_cast<float>(px.x()), static_cast<float>(px.y()));
  }
  constexpr float kEnd = static_cast<float>(kSheet_px) - 0.5F;
  const std::vector<cv::Point2f> printed = {
      {-0.5F, -0.5F}, {kEnd, -0.5F}, {kEnd, kEnd}, {-0.5F, kEnd}};
  const cv::Mat H = cv::getPerspectiveTransform(printed, seen);
  cv::Mat drawn, mask;
  cv::warpPerspective(sheet, drawn, H, image.size(), cv::INTER_AREA);
  cv::warpPerspective(cv::Mat(sheet.size(), CV_8UC1, cv::Scalar(255)), mask, H, image.size());
  drawn.copyTo(image, mask > 127);
}

TEST(ExampleDetector, FindsABoxWithMarkers) {
  const EntityModels models({boxEntity(EntityId{5})});
  DetectorRegistry table("entity detector");
  table.add("aruco", [](const PerceptionParams& params, const EntityModels& m) {
    return std::make_unique<ArucoDetector>(params, m);
  });
  const auto detector = table.make("aruco", PerceptionParams(), models);

  CameraImage image;
  image.stamp = Stamp::fromSeconds(100.0);
  image.label = "camera";
  image.model = testCamera(DistortionModel::kNone);
  image.T_base_camera = forwardCamera();
  image.grey = blankImage(image.model);
  const Pose3 T_camera_entity = uprightAhead(1.8, pi + 0.8);
  for (const TagModel& tag : models.all()[0].tags)
    drawMarker(tag, image.model, T_camera_entity, image.grey);
  TagModel stranger = models.all()[0].tags[0];
  stranger.tag_id = 99;
  drawMarker(stranger, image.model, uprightAhead(3.0, pi, 1.0), image.grey);
  SensorFrame frame;
  frame.stamp = image.stamp;
  frame.images.push_back(image);

  const auto observations = detector->detect(frame);
  ASSERT_EQ(observations.size(), 1U);
  EXPECT_EQ(observations[0].entity, EntityId{5});
  EXPECT_EQ(observations[0].tag_count, 2);
  const Vector6 error = local(forwardCamera() * T_camera_entity, observations[0].T_base_entity);
  EXPECT_LT(error.head<3>().norm(), 0.02);
  EXPECT_LT(error.tail<3>().norm(), 0.03);
  EXPECT_EQ(detector->warnings().at("unknown marker id"), 1U);
}

TEST(ExampleFactor, HasRightJacobians) {
  constexpr double kStep = 1e-6, kTolerance = 1e-8;
  std::mt19937_64 rng(5);
  for (int sample = 0; sample < 20; ++sample) {
    const auto edge = CEdgeEntityDistance::example(rng);
    const std::vector<CNodeBase::Ptr> nodes = {nodeTypeOf("entity").example(rng),
                                               nodeTypeOf("entity").example(rng)};
    const States at(nodes);
    Residual e;
    Jacobians J;
    edge->evaluate(at.pointers(), e, &J);
    for (std::size_t n = 0; n < nodes.size(); ++n)
      for (int i = 0; i < 6; ++i) {
        const auto moved = [&](double step) {
          double delta[6] = {};
          delta[i] = step;
          States states(nodes);
          nodes[n]->retract(std::vector(states.pointers()[n], states.pointers()[n] + 12).data(),
                            delta, states.of(n));
          return residualAt(*edge, states)[0];
        };
        EXPECT_NEAR(J[n](0, i), (moved(kStep) - moved(-kStep)) / (2.0 * kStep), kTolerance);
      }
  }
}

TEST(ExampleFactor, IsStored) {
  mrpt::rtti::registerClass(CLASS_ID(CEdgeEntityDistance));
  std::mt19937_64 rng(5);
  const auto edge = CEdgeEntityDistance::example(rng);
  edge->nodes = {NodeId{3}, NodeId{4}};
  mrpt::io::CMemoryStream stream;
  auto archive = mrpt::serialization::archiveFrom(stream);
  archive << *edge;
  stream.Seek(0);
  const auto read = archive.ReadObject<CEdgeEntityDistance>();
  ASSERT_TRUE(read);
  EXPECT_EQ(read->distance_m, edge->distance_m);
  EXPECT_EQ(read->nodes, edge->nodes);
  EXPECT_EQ(read->information(), edge->information());
}

TEST(ExampleMotionModel, TiesObservationsTogether) {
  MotionModelRegistry r("motion model");
  r.add("anchored", [](const MotionParams& p) { return std::make_unique<AnchoredModel>(p); });
  CNodeEntity before, after;
  before.id = NodeId{3};
  after.id = NodeId{8};
  after.T_map_node = Pose3::translation(2, 0, 0);
  const std::vector<const CNodeEntity*> history = {&before};
  const auto constraint = r.make("anchored", MotionParams())
                              ->constrain({nullptr, history, after, Matrix6::Identity() * 1e-4});
  EXPECT_FALSE(constraint.moved);
  ASSERT_EQ(constraint.edges.size(), 1U);
  EXPECT_EQ(constraint.edges[0]->nodes, (std::vector{NodeId{3}, NodeId{8}}));
}

TEST(ExampleMatcher, FindsTheRelativePose) {
  ScanMatcherRegistry r("scan matcher");
  r.add("point_icp", makePointIcp);
  const MatchingParams params;
  const auto matcher = r.make("point_icp", params);
  const ScanPair pair = roomPair();
  const MatchScan target(pair.target, params.scan), source(pair.source, params.scan);
  const auto found =
      matcher->match(target, source, {disturbed(pair.T_target_source, 0.15, 0.05), 0.1, 0.05});
  ASSERT_TRUE(found) << toString(found.error());
  const Vector6 error = local(pair.T_target_source, found->T_target_source);
  EXPECT_LT(error.head<3>().norm(), 0.05);
  EXPECT_LT(error.tail<3>().norm(), 0.02);
  EXPECT_FALSE(matcher->match(target, source, {Pose3::translation(200, 0, 0), 0.1, 0.05}));
}

}  // namespace
}  // namespace dynemo::test
