#include "dynemo/simulation/collisions.h"

#include <gtest/gtest.h>

#include <numbers>

#include "dynemo/core/error.h"
#include "small_world.h"

namespace dynemo::simulation::test {
namespace {

/// Of the small world, long enough for the whole route, after a change.
template <class Change>
std::string complaint(Change change) {
  World world = smallWorld();
  world.duration_s = 12.0;
  change(world);
  try {
    requireFreeWay(world);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "free";
}

void expectIn(const std::string& message, const std::string& part) {
  EXPECT_NE(message.find(part), std::string::npos) << message;
}

TEST(FreeWay, TheSmallWorldHasIt) {
  EXPECT_EQ(complaint([](World&) {}), "free");
}

TEST(FreeWay, NamesWhatTheRobotMeets) {
  expectIn(complaint([](World& w) { w.robot.route[0].at.y() = 1.0; }),
           "robot: meets ground: wall 4");
  expectIn(complaint([](World& w) { w.storeys[0].furniture[0].at.y() = 2.6; }),
           "robot: meets ground: table");
  expectIn(complaint([](World& w) {
             w.relocations.back().to = {4.2, 2.2};
           }),
           "robot: meets entity 1");
  expectIn(complaint([](World& w) {
             w.entities[2].path->from.y() = 2.6;
             w.entities[2].path->phase_s = 3.7;
           }),
           "robot: meets entity 101");
  expectIn(complaint([](World& w) { w.robot.height_m = 2.3; }), "robot: meets ground: wall 4");
}

TEST(FreeWay, NamesTheEntityThatMeetsAWall) {
  expectIn(complaint([](World& w) { w.entities[2].path->to.x() = 4.9; }),
           "entity 101: meets ground: wall 4");
  expectIn(complaint([](World& w) { w.relocations.back().to.x() = 4.9; }),
           "entity 1: meets ground: wall 4");
}

TEST(Blocked, LooksThroughDoorsNotThroughWalls) {
  const auto solids = obstacles(smallWorld());
  EXPECT_FALSE(isBlocked(solids, {1, 2.5, 1}, {7, 2.5, 1}));
  EXPECT_TRUE(isBlocked(solids, {1, 2.5, 2.4}, {7, 2.5, 2.4})) << "the lintel";
  EXPECT_TRUE(isBlocked(solids, {1, 1.5, 1}, {7, 1.5, 1}));
}

TEST(Footprint, DistanceIsToTheTurnedRectangle) {
  const Footprint f{
      Pose3::fromYawPitchRoll(1, 1, 0, std::numbers::pi / 2, 0, 0), {2, 0.5, 1}, "it"};
  EXPECT_NEAR(f.distance({1, 4}), 1.0, 1e-12);
  EXPECT_NEAR(f.distance({2.5, 1}), 1.0, 1e-12);
  EXPECT_EQ(f.distance({1.2, 1.5}), 0.0);
}

}  // namespace
}  // namespace dynemo::simulation::test
