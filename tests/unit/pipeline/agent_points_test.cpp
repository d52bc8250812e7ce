#include "dynemo/pipeline/agent_points.h"

#include <gtest/gtest.h>

#include "frames.h"

namespace dynemo {
namespace {

using test::at;

/// A row of points along x at y = 0, every decimetre from 0 to 10 m.
SensorFrame rowFrame(double seconds, const Pose3& T_odom_base) {
  SensorFrame frame = test::frameAt(seconds, T_odom_base);
  Scan scan;
  scan.stamp = frame.stamp;
  for (int i = 0; i <= 100; ++i) scan.cloud.points.emplace_back(0.1F * static_cast<float>(i), 0, 0);
  frame.scan = scan;
  return frame;
}

EntityObservation seen(int id, SemanticClass semantic_class, double x_base_m) {
  EntityObservation observation;
  observation.entity = {id};
  observation.semantic_class = semantic_class;
  observation.T_base_entity = Pose3::translation(x_base_m, 0.0, 0.7);
  return observation;
}

PointIndices range(std::uint32_t first, std::uint32_t last) {
  PointIndices indices;
  for (std::uint32_t i = first; i <= last; ++i) indices.push_back(i);
  return indices;
}

AgentPointsParams params() {
  AgentPointsParams p;
  p.radius_m = 0.55;
  p.growth_m_s = 0.0;
  return p;
}

TEST(AgentPoints, AreThoseAroundAgentsInView) {
  const AgentPoints points(params());
  const SensorFrame frame = rowFrame(0, Pose3());
  EXPECT_EQ(points.of(frame, {seen(1, SemanticClass::kAgent, 5.0)}), range(45, 55));
  EXPECT_TRUE(points.of(frame, {seen(1, SemanticClass::kObject, 5.0)}).empty());
  EXPECT_TRUE(points.of(frame, {}).empty());
}

TEST(AgentPoints, FollowAnAgentOutOfSightForAWhile) {
  AgentPoints points(params());
  // It walks at 1 m/s along the x axis of odom while the robot drives at 2 m/s.
  points.remember(at(0.0), Pose3(), {seen(1, SemanticClass::kAgent, 4.0)});
  points.remember(at(0.5), Pose3::translation(1, 0, 0), {seen(1, SemanticClass::kAgent, 3.5)});
  // At 1.0 s it is at 5 m in odom, 3 m ahead of the robot.
  EXPECT_EQ(points.of(rowFrame(1.0, Pose3::translation(2, 0, 0)), {}), range(25, 35));
  EXPECT_TRUE(points.of(rowFrame(1.6, Pose3::translation(3.2, 0, 0)), {}).empty()) << "forgotten";
}

TEST(AgentPoints, WhatIsSeenCountsMoreThanWhatIsExpected) {
  AgentPoints points(params());
  points.remember(at(0.0), Pose3(), {seen(1, SemanticClass::kAgent, 4.0)});
  EXPECT_EQ(points.of(rowFrame(0.2, Pose3()), {seen(1, SemanticClass::kAgent, 8.0)}),
            range(75, 85));
}

TEST(AgentPoints, TheCylinderGrowsWithTheAge) {
  AgentPointsParams growing = params();
  growing.growth_m_s = 1.0;
  AgentPoints points(growing);
  points.remember(at(0.0), Pose3(), {seen(1, SemanticClass::kAgent, 5.0)});
  EXPECT_EQ(points.of(rowFrame(0.5, Pose3()), {}), range(40, 60));
}

}  // namespace
}  // namespace dynemo
