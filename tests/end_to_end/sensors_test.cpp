// Rawlogs with fewer sensors, and detections of other programs.
#include <gtest/gtest.h>

#include "dynemo/core/noise.h"
#include "dynemo/core/output_file.h"
#include "dynemo/evaluation/trajectory.h"
#include "dynemo/graph/edge_relative_pose.h"
#include "dynemo/graph/session.h"
#include "slam_run.h"

namespace dynemo::test {
namespace {

constexpr std::size_t kFrames = 131;
/// Bound of the full run on the bundled sample.
constexpr double kFullAte_m = 0.0225;

/// The bundled sample without some of its sensors.
class FewerSensors : public testing::Test {
 protected:
  Dataset without(const std::set<std::string>& labels) {
    const Dataset d = bundledSample(), here{folder_.path(), "fewer"};
    copyRawlog(d.rawlog(), here.rawlog(), withoutLabels(labels));
    fs::create_directory_symlink(d.images(), here.images());
    for (const auto& [from, to] :
         {std::pair{d.entities(), here.entities()}, std::pair{d.truth(), here.truth()},
          std::pair{d.entityTruth(), here.entityTruth()}})
      fs::create_symlink(from, to);
    return here;
  }
  TemporaryFolder folder_;
};

TEST_F(FewerSensors, WithoutCamera) {
  const SlamRun run(without({"camera"}));
  ASSERT_TRUE(run.ok()) << describe(run.outcome());
  EXPECT_EQ(run.nodes("entity"), 0u);
  EXPECT_EQ(readTum(run.folder() / "trajectory.tum").size(), kFrames);
  EXPECT_NE(run.outcome().out.find("0 objects, 0 agents"), std::string::npos);
}

TEST_F(FewerSensors, WithoutLidar) {
  const Dataset d = without({"lidar"});
  const SlamRun run(d);
  ASSERT_TRUE(run.ok()) << describe(run.outcome());
  EXPECT_LE(ate(run.evaluate()), kFullAte_m);
  EXPECT_EQ(run.movedObjects(), displacedObjects(d));
  EXPECT_GT(run.edges("floor_entity"), 0u) << "from entities of known height";
}

TEST_F(FewerSensors, WithoutRecordedOdometryTheScansGiveIt) {
  const Dataset d = without({"odom2d", "odom3d"});
  const SlamRun run(d);
  ASSERT_TRUE(run.ok()) << describe(run.outcome());
  EXPECT_LE(ate(run.evaluate()), 0.02);
  EXPECT_EQ(run.movedObjects(), displacedObjects(d));
}

TEST_F(FewerSensors, RecordedOdometryThatIsAskedForMustBeThere) {
  const Dataset d = without({"odom2d", "odom3d"});
  expectRefusal(slam(slamCommand(d, folder_ / "run", {"--set", "odometry.source=rawlog"})), 2,
                {"odometry.source", "rawlog"});
}

TEST_F(FewerSensors, PlanarOdometryServesToo) {
  const Dataset d = without({"odom3d"});
  const SlamRun run(d);
  ASSERT_TRUE(run.ok()) << describe(run.outcome());
  const nlohmann::json evaluation = run.evaluate();
  EXPECT_LT(ate(evaluation), 0.6 * ate(evaluation, "odometry"));
  // Wheel odometry says nothing of its noise, so that drift may pass for a motion, but no motion
  // for drift.
  EXPECT_EQ(evaluation.at("entities").at("changes").at("moved_by_object").at("recall"), 1.0);
  EXPECT_EQ(evaluation.at("entities").at("changes").at("objects_at_end").at("recall"), 1.0);
}

TEST_F(FewerSensors, OnlyOdometry) {
  const SlamRun run(without({"lidar", "camera"}));
  ASSERT_TRUE(run.ok()) << describe(run.outcome());
  EXPECT_GT(readTum(run.folder() / "trajectory.tum").size(), kFrames);
}

TEST_F(FewerSensors, AConfiguredSensorThatIsNotThereIsNamed) {
  expectRefusal(
      slam(slamCommand(bundledSample(), folder_ / "run", {"--set", "sensors.lidar.label=roof"})), 3,
      {"roof"});
}

/// Every keyframe–entity edge of a session as a row of a detections table: the pose in the base
/// frame with its covariance, translation along the base's axes.
std::string detectionsTable(const CSceneGraph& graph) {
  std::string table;
  for (const auto& slot : graph.edgeSlots()) {
    const auto* edge = dynamic_cast<const CEdgeKeyframeEntity*>(slot.get());
    if (edge == nullptr) continue;
    const auto& entity = graph.getNode<CNodeEntity>(edge->nodes[1]);
    const Eigen::Quaterniond q = edge->T_1_2.quaternion();
    const Matrix6 tangent_cov = *invertSpd(edge->information());
    const Matrix6 cov = covarianceTranslationToParent(tangent_cov, edge->T_1_2.R);
    table += entity.stamp.text() + "," + std::to_string(entity.entity.value) + "," +
             semanticClassName(entity.semantic_class);
    for (const double v :
         {edge->T_1_2.t.x(), edge->T_1_2.t.y(), edge->T_1_2.t.z(), q.x(), q.y(), q.z(), q.w()})
      table += "," + exactNumber(v);
    table += ",";
    for (int r = 0; r < 6; ++r) {
      for (int c = r; c < 6; ++c) table += "," + exactNumber(cov(r, c));
    }
    table += "\n";
  }
  return table;
}

class Detections : public testing::Test {
 protected:
  void SetUp() override {
    const SlamRun& first = bundledRun("full");
    ASSERT_TRUE(first.ok());
    const Session session = loadSession(first.folder() / "session");
    const std::string table = detectionsTable(session.graph);
    rows_ = static_cast<std::size_t>(std::count(table.begin(), table.end(), '\n'));
    ASSERT_GT(rows_, 100u);
    writeBytes(csv(), table);
  }
  fs::path csv() const { return folder_ / "detections.csv"; }

  TemporaryFolder folder_;
  std::size_t rows_ = 0;
};

TEST_F(Detections, OfAnotherDetectorServeInPlaceOfTags) {
  const SlamRun run(bundledSample(), {"--setup", "full", "--set", "perception.detectors=[external]",
                                      "--detections", csv()});
  ASSERT_TRUE(run.ok()) << describe(run.outcome());
  EXPECT_EQ(run.summary().at("observations").at("(detections table)"), rows_);
  EXPECT_GT(run.nodes("entity"), rows_ * 8 / 10) << "the keyframes are nearly the same";
  EXPECT_LE(ate(run.evaluate()), kFullAte_m);
  EXPECT_EQ(run.movedObjects(), displacedObjects(bundledSample()));
}

TEST_F(Detections, NeedNoRawlogAndNoEntityFile) {
  const Outcome run = slam({"--detections", csv(), "--output", folder_ / "run"});
  ASSERT_EQ(run.status, 0) << describe(run);
  const nlohmann::json summary = readJson(folder_ / "run" / "summary.json");
  EXPECT_EQ(summary.at("entities").size(), bundledRun("full").summary().at("entities").size());
  EXPECT_GT(warningCount(summary, "without odometry"), 0u);
  EXPECT_GT(readTum(folder_ / "run" / "trajectory.tum").size(), 50u);
}

TEST_F(Detections, InASensorsFrameNeedThatSensorsPose) {
  std::string table = readBytes(csv());
  for (auto at = table.find(",,"); at != std::string::npos; at = table.find(",,", at))
    table.replace(at, 2, ",nose,");
  writeBytes(folder_ / "labelled.csv", table);
  const Arguments command = {"--detections", folder_ / "labelled.csv", "--output", folder_ / "run"};
  expectRefusal(slam(command), 3, {"nose"});
  Arguments with_pose = command;
  with_pose.insert(with_pose.end(), {"--set", "sensors.extrinsics={nose: [0, 0, 0, 0, 0, 0, 1]}"});
  const Outcome run = slam(with_pose);
  EXPECT_EQ(run.status, 0) << describe(run);
}

}  // namespace
}  // namespace dynemo::test
