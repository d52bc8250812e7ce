// Planes as they are drawn: where they were seen, and no further.
#include "plane_faces.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "dynemo/graph/edge_plane.h"
#include "edge_lines.h"
#include "small_run.h"

namespace dynemo::test {
namespace {

constexpr NodeId kPlane{7};

/// The small run, with a wall at x = 3 m that keyframe 0 saw in six cells.
SmallRun runWithWall() {
  SmallRun run = smallRun();
  auto wall = std::make_shared<CNodePlane>();
  wall->id = kPlane;
  wall->plane_map = Plane3::through({3.0, 0.0, 0.0}, -Vector3::UnitX());
  auto seen = std::make_shared<CEdgeKeyframePlane>();
  seen->id = run.graph.nextEdgeId();
  seen->nodes = {{0}, kPlane};
  seen->patch_base.center = {3.0, 0.0, 0.0};
  seen->patch_base.normal = -Vector3::UnitX();
  for (std::int16_t a = 0; a < 2; ++a)
    for (std::int16_t b = 0; b < 3; ++b) seen->patch_base.cells.push_back({a, b});
  seen->point_count = 60;
  seen->setInformation(Matrix3::Identity());
  GraphDelta delta;
  delta.nodes = {wall};
  delta.edges = {seen};
  run.graph.apply(delta);
  return run;
}

double area(const std::vector<Vector3>& triangles) {
  double sum = 0.0;
  for (std::size_t i = 0; i + 2 < triangles.size(); i += 3) {
    sum += 0.5 * (triangles[i + 1] - triangles[i]).cross(triangles[i + 2] - triangles[i]).norm();
  }
  return sum;
}

TEST(PlaneFaces, CoverWhatWasSeen) {
  const SmallRun run = runWithWall();
  const auto faces = planeFaces(run.graph);
  ASSERT_EQ(faces.size(), 1u);
  EXPECT_EQ(faces[0].plane->id, kPlane);
  EXPECT_FALSE(faces[0].is_ceiling);
  EXPECT_GT(faces[0].area_m2, 0.0);
  EXPECT_NEAR(area(faces[0].triangles), faces[0].area_m2, 1e-9);
  for (const Vector3& p : faces[0].triangles) {
    EXPECT_NEAR(p.x(), 3.0, 1e-9);
    EXPECT_LT((p - Vector3(3.0, 0.0, 0.0)).norm(), 1.5);
  }
}

TEST(PlaneFaces, EdgesLeadToTheMiddleOfThePlane) {
  const SmallRun run = runWithWall();
  const Vector3 middle = planeFaces(run.graph)[0].middle;
  bool found = false;
  for (const EdgeKindLines& kind : edgeLines(run.graph)) {
    if (kind.kind != "keyframe_plane") continue;
    found = true;
    EXPECT_LT((kind.edges.at(0).lines.at(0).to - middle).norm(), 1e-12);
  }
  EXPECT_TRUE(found);
}

TEST(PlaneFaces, AreInEveryFormatThatDrawsTheGraph) {
  const SmallRun run = runWithWall();
  EXPECT_NE(exported("gltf", run.result()).find("\"plane 7\""), std::string::npos);
  EXPECT_NE(exported("html", run.result()).find("plane 7"), std::string::npos);
  const auto spark = nlohmann::json::parse(exported("spark-dsg", run.result()));
  bool found = false;
  for (const auto& node : spark.at("nodes")) {
    if (node.at("id").get<std::uint64_t>() != ((std::uint64_t{'P'} << 56u) | kPlane.value))
      continue;
    found = true;
    EXPECT_NEAR(node.at("attributes").at("position").at(0).get<double>(), 3.0, 1e-9);
  }
  EXPECT_TRUE(found);
  EXPECT_NE(exported("csv", run.result()).find(",plane,"), std::string::npos);
}

}  // namespace
}  // namespace dynemo::test
