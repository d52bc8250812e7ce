#include "mapped_surfaces.h"

#include <gtest/gtest.h>

#include "dynemo/graph/edge_plane.h"

namespace dynemo::test {
namespace {

using Kind = MappedSurfaces::Kind;

/// A wall at x = 4 m, |y| < 1 m, 0 m < z < 2 m, and the floor at z = 0.
class Surfaces : public testing::Test {
 protected:
  Surfaces() {
    auto keyframe = std::make_shared<CNodeKeyframe>();
    keyframe->id = {0};
    auto plane = std::make_shared<CNodePlane>();
    plane->id = {1};
    plane->plane_map = {Vector3(-1, 0, 0), 4.0};
    auto floor = std::make_shared<CNodeFloor>();
    floor->id = {2};
    floor->extendArea({Vector2(0, -2), Vector2(4, 2)});
    auto edge = std::make_shared<CEdgeKeyframePlane>();
    edge->id = {0};
    edge->nodes = {{0}, {1}};
    edge->setInformation(Matrix3::Identity());
    edge->patch_base.normal = {-1, 0, 0};
    edge->patch_base.center = {4, 0, 1};
    for (std::int16_t a = -4; a < 4; ++a)
      for (std::int16_t b = -4; b < 4; ++b) edge->patch_base.cells.push_back({a, b});
    graph_.apply(GraphDelta{{keyframe, plane, floor}, {edge}, {}});
  }

  /// Rays to the wall; those with y > `open_m` go through it.
  static PointCloud wall(double open_m) {
    PointCloud cloud;
    for (double y = -0.98; y < 1.0; y += 0.03) {
      for (double z = 0.02; z < 2.0; z += 0.03)
        cloud.points.push_back(((y > open_m ? 2.0 : 1.0) * Vector3(4, y, z)).cast<float>());
    }
    return cloud;
  }

  CSceneGraph graph_;
};

TEST_F(Surfaces, ArePlanesWhereTheyWereSeenAndFloorsAllOver) {
  const MappedSurfaces surfaces(graph_, 0.05);
  EXPECT_EQ(surfaces.at({4.03, 0.5, 1.0}), Kind::kPlane);
  EXPECT_EQ(surfaces.at({3.9, 0.5, 1.0}), Kind::kNone);
  EXPECT_EQ(surfaces.at({4.0, 1.6, 1.0}), Kind::kNone);
  EXPECT_EQ(surfaces.at({4.0, 0.5, 2.6}), Kind::kNone);
  EXPECT_EQ(surfaces.at({2.0, 1.6, 0.03}), Kind::kFloor);
  EXPECT_EQ(surfaces.at({2.0, 9.0, 0.03}), Kind::kNone);
}

TEST_F(Surfaces, EndWhereScansSeeThrough) {
  MappedSurfaces surfaces(graph_, 0.05);
  const StructureParams params;
  const PointCloud cloud = wall(0.5);
  std::vector<Viewpoint> scans;
  for (int i = 0; i < 4; ++i) scans.push_back({Vector3::Zero(), {1'000'000'000LL * i}});
  surfaces.prepare(scans, params);
  for (std::size_t i = 0; i < scans.size(); ++i) {
    surfaces.sights().look(i, BeamGrid(cloud, std::vector<BeamEnd>(cloud.size(), BeamEnd::kThing)),
                           Pose3());
  }
  EXPECT_TRUE(surfaces.eraseSeenThrough());
  EXPECT_EQ(surfaces.at({4.0, 0.3, 1.0}), Kind::kPlane);
  EXPECT_EQ(surfaces.at({4.0, -0.8, 1.0}), Kind::kPlane);
  EXPECT_EQ(surfaces.at({4.0, 0.8, 1.0}), Kind::kNone);
}

}  // namespace
}  // namespace dynemo::test
