#include "dynemo/evaluation/run_report.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "example_run.h"

namespace dynemo::test {
namespace {

constexpr double kTolerance = 1e-6;

/// A run whose map is turned against the world; odometry 10 % too long in x.
void writeRun(const Folder& folder) {
  const Pose3 T_map_world = Pose3::fromYawPitchRoll(1, 2, 3, 0.5, 0, 0);
  const Trajectory truth = curve(80), map = transformed(truth, T_map_world);
  Trajectory odometry = map, keyframes;
  for (auto& pose : odometry) pose.T.t.x() *= 1.1;
  for (std::size_t i = 0; i < map.size(); i += 8) keyframes.push_back(map[i]);
  writeTum(map, folder.path() / "trajectory.tum");
  writeTum(odometry, folder.path() / "odometry.tum");
  writeTum(keyframes, folder.path() / "keyframes.tum");
  const Eigen::Vector3d p = T_map_world * Vector3(0, 5.02, 0);
  const Eigen::Quaterniond q = T_map_world.quaternion();
  const auto number = [](double v) { return std::to_string(v); };
  const std::string pose = number(p.x()) + "," + number(p.y()) + "," + number(p.z()) + "," +
                           number(q.x()) + "," + number(q.y()) + "," + number(q.z()) + "," +
                           number(q.w());
  folder.write("entities.csv",
               "node_id,entity_id,class,name,timestamp,keyframe_id,moved,x,y,z,qx,qy,qz,qw,first_x,"
               "first_y,first_z,"
               "first_qx,first_qy,first_qz,first_qw\n3,2,object,crate,1700000005,1,0," +
                   pose + "," + pose + "\n");
}

TEST(RunReport, EvaluatesAFolder) {
  const Folder folder;
  writeRun(folder);
  const EntityTruths truths = exampleTruths();
  const RunReport report = evaluateRun(folder.path(), curve(80), &truths);
  EXPECT_LT(report.trajectory.ate_m.rmse, kTolerance);
  ASSERT_TRUE(report.keyframes && report.odometry && report.entities);
  EXPECT_EQ(report.keyframes->ate_m.count, 10u);
  EXPECT_GT(report.odometry->ate_m.rmse, 0.05);
  EXPECT_NEAR(report.entities->errors.nodes.at(0).final.translation_m, 0.02, 1e-5);
  EXPECT_NE(reportText(report).find("2 crate, place 1"), std::string::npos);
}

TEST(RunReport, JsonHoldsTheFiguresAndNullForNone) {
  const Folder folder;
  writeRun(folder);
  const EntityTruths truths = exampleTruths();
  const auto json =
      nlohmann::json::parse(reportJson(evaluateRun(folder.path(), curve(80), &truths)));
  EXPECT_EQ(json["trajectory"]["ate_m"]["count"], 80);
  EXPECT_NEAR(json["entities"]["object_placements"]["last"]["translation_m"]["max"].get<double>(),
              0.02, 1e-5);
  EXPECT_EQ(json["entities"]["changes"]["moved_by_object"]["precision"], 1.0);
  EXPECT_TRUE(json["entities"]["agents"]["final"]["translation_m"]["rmse"].is_null());
}

TEST(RunReport, TakesASingleTrajectory) {
  const Folder folder;
  writeRun(folder);
  const RunReport report = evaluateRun(folder.path() / "odometry.tum", curve(80), nullptr);
  EXPECT_GT(report.trajectory.ate_m.rmse, 0.05);
  EXPECT_FALSE(report.keyframes || report.odometry || report.entities);
}

TEST(RunReport, AnInterruptedRunNeedsOnlyItsTrajectory) {
  const Folder folder;
  writeRun(folder);
  std::filesystem::remove(folder.path() / "odometry.tum");
  std::filesystem::remove(folder.path() / "keyframes.tum");
  EXPECT_FALSE(evaluateRun(folder.path(), curve(80), nullptr).odometry);
  std::filesystem::remove(folder.path() / "trajectory.tum");
  EXPECT_NE(
      dataError([&] { evaluateRun(folder.path(), curve(80), nullptr); }).find("trajectory.tum"),
      std::string::npos);
}

TEST(RunReport, SaysWhyATrajectoryCannotBeAligned) {
  const Folder folder;
  const auto file = folder.write("late.tum", "1 0 0 0 0 0 0 1\n2 0 1 0 0 0 0 1\n3 1 1 0 0 0 0 1\n");
  const std::string message = dataError([&] { evaluateRun(file, curve(80), nullptr); });
  EXPECT_NE(message.find("late.tum"), std::string::npos);
  EXPECT_NE(message.find("fewer than three"), std::string::npos);
}

}  // namespace
}  // namespace dynemo::test
