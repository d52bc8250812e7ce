#include "dynemo/simulation/robot_motion.h"

#include <gtest/gtest.h>

#include "small_world.h"

namespace dynemo::simulation::test {
namespace {

TEST(SmoothCurve, KeepsStraightLinesAndRoundsCornersByTheMovingAverage) {
  const SmoothCurve curve({{0.0, {0, 0, 0, 1}}, {2.0, {4, 0, 0, 1}}, {4.0, {4, 2, 0, 1}}}, 0.5);
  EXPECT_NEAR(curve.at(1.0)[0], 2.0, 1e-12);
  EXPECT_NEAR(curve.at(3.0)[1], 1.0, 1e-12);
  EXPECT_NEAR(curve.at(-1.0)[0], 0.0, 1e-12);
  EXPECT_NEAR(curve.at(9.0)[1], 2.0, 1e-12);
  EXPECT_NEAR(curve.at(0.3)[3], 1.0, 1e-12) << "the weights sum to one";
  // At a kink of slope change k the triangle average adds k h / 6.
  EXPECT_NEAR(curve.at(2.0)[0], 4.0 - 2.0 * 0.5 / 6.0, 1e-12);
  EXPECT_NEAR(curve.at(2.0)[1], 1.0 * 0.5 / 6.0, 1e-12);
}

TEST(RobotMotion, IsContinuousInPoseAndVelocity) {
  const World world = smallWorld();
  for (const Carrier carrier : {Carrier::kWheels, Carrier::kHand}) {
    Robot robot = world.robot;
    robot.carrier = carrier;
    const RobotMotion motion(robot, world.seed);
    constexpr double kStep_s = 1e-3;
    Vector6 before = Vector6::Zero();
    for (double t_s = 0.0; t_s < motion.end_s() + 1.0; t_s += kStep_s) {
      const Vector6 velocity = local(motion.at(t_s), motion.at(t_s + kStep_s)) / kStep_s;
      if (t_s > 0.0) {
        EXPECT_LT((velocity - before).head<3>().norm(), 20 * kStep_s) << "m/s² at " << t_s;
        EXPECT_LT((velocity - before).tail<3>().norm(), 40 * kStep_s) << "rad/s² at " << t_s;
      }
      before = velocity;
    }
  }
}

TEST(RobotMotion, StandsStillOnWheelsWhileItWaits) {
  const World world = smallWorld();
  const RobotMotion motion(world.robot, world.seed);
  const double end_s = motion.end_s();
  EXPECT_LT(local(motion.at(end_s + 1.0), motion.at(end_s + 2.0)).norm(), 1e-12);
  EXPECT_NEAR(motion.distance(end_s + 1.0), 5.0 + 1.3, 1e-9);
  EXPECT_NEAR((motion.floorPoint(end_s + 1.0) - Vector3(6.0, 1.2, 0.0)).norm(), 0.0, 1e-9);
}

TEST(RobotMotion, FollowsASlopeWithItsPitch) {
  Robot robot;
  robot.route = {{{0, 0, 0}, 0}, {{2, 0, 0}, 0}, {{6, 0, 1}, 0}, {{8, 0, 1}, 0}};
  const RobotMotion motion(robot, 1);
  const double middle_s = 4.0 / robot.speed_m_s;
  EXPECT_NEAR(std::asin(motion.at(middle_s).R(2, 0)), std::atan2(1.0, 4.0), 0.02) << "nose up";
  EXPECT_NEAR(motion.at(middle_s).t.z(), 0.5 + robot.base_height_m, 0.05);
}

}  // namespace
}  // namespace dynemo::simulation::test
