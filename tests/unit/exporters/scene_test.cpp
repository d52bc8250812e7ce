// Reads scene.3Dscene back with MRPT and looks for what must be in it.
#include <gtest/gtest.h>
#include <mrpt/opengl/CArrow.h>
#include <mrpt/opengl/CBox.h>
#include <mrpt/opengl/COpenGLScene.h>
#include <mrpt/opengl/CPointCloudColoured.h>
#include <mrpt/opengl/CSetOfLines.h>
#include <mrpt/opengl/CText3D.h>
#include <mrpt/opengl/registerAllClasses.h>

#include <fstream>
#include <set>

#include "dynemo/graph/types.h"
#include "scene_style.h"
#include "small_run.h"

namespace dynemo::test {
namespace {

using mrpt::opengl::CSetOfObjects;

mrpt::opengl::COpenGLScene readBack(const RunResult& run) {
  mrpt::opengl::registerAllClasses_mrpt_opengl();
  const TemporaryFolder folder;
  const auto file = folder.path() / "scene.3Dscene";
  std::ofstream(file, std::ios::binary) << exported("3dscene", run);
  mrpt::opengl::COpenGLScene scene;
  EXPECT_TRUE(scene.loadFromFile(file.string()));
  return scene;
}

template <class Object>
std::vector<std::shared_ptr<Object>> all(const CSetOfObjects& group) {
  std::vector<std::shared_ptr<Object>> list;
  for (const auto& object : group) {
    if (auto match = std::dynamic_pointer_cast<Object>(object)) list.push_back(match);
    if (auto inner = std::dynamic_pointer_cast<CSetOfObjects>(object)) {
      for (const auto& match : all<Object>(*inner)) list.push_back(match);
    }
  }
  return list;
}

TEST(Scene, HoldsEveryPartByName) {
  const SmallRun run = smallRun();
  auto scene = readBack(run.result());
  for (const char* name : {"floors", "clouds", "trajectory", "edges", "entities", "floor 2",
                           "keyframe clouds", "entity fragments", "optimised", "odometry",
                           "keyframe 5", "odometry", "loop_closure", "walker 101"}) {
    EXPECT_TRUE(scene.getByName(name)) << name;
  }
}

TEST(Scene, DrawsEdgesInTheColoursOfTheirKinds) {
  const SmallRun run = smallRun();
  const auto edges = sceneEdges(run.result(), SceneParams());
  std::set<std::string> kinds;
  for (const auto& lines : all<mrpt::opengl::CSetOfLines>(*edges)) {
    kinds.insert(lines->getName());
    const auto color = lines->getColor_u8();
    const std::uint32_t rgb = (color.R << 16u) | (color.G << 8u) | color.B;
    EXPECT_EQ(rgb, edgeType(lines->getName()).color_rgb) << lines->getName();
  }
  EXPECT_EQ(kinds, (std::set<std::string>{"floor_entity", "intra_entity", "keyframe_entity",
                                          "loop_closure", "odometry"}));
}

TEST(Scene, ShowsADisplacedObjectBeforeAndAfter) {
  const SmallRun run = smallRun();
  const auto entities = sceneEntities(run.result(), SceneParams());
  EXPECT_EQ(all<mrpt::opengl::CArrow>(*entities).size(), 1u);
  // Two entities now, and the box's ghost as faces and as wireframe.
  EXPECT_EQ(all<mrpt::opengl::CBox>(*entities).size(), 4u);
}

TEST(Scene, NamesTheEntities) {
  const SmallRun run = smallRun();
  std::set<std::string> titles;
  for (const auto& text : all<mrpt::opengl::CText3D>(*sceneEntities(run.result(), SceneParams()))) {
    titles.insert(text->getString());
  }
  EXPECT_EQ(titles, (std::set<std::string>{"box, \"red\" 7", "walker 101"}));
}

std::size_t pointCount(const RunResult& run, const SceneParams& params) {
  std::size_t count = 0;
  for (const auto& cloud : all<mrpt::opengl::CPointCloudColoured>(*sceneClouds(run, params))) {
    count += cloud->size();
  }
  return count;
}

TEST(Scene, ThinsCloudsToTheBudget) {
  const SmallRun run = smallRun();
  SceneParams params;
  params.exports.picture.voxel_m = 1e-3;
  EXPECT_EQ(pointCount(run.result(), params), 150u);
  params.exports.picture.max_points = 20;
  const std::size_t thinned = pointCount(run.result(), params);
  EXPECT_GT(thinned, 5u);
  EXPECT_LE(thinned, 2 * static_cast<std::size_t>(params.exports.picture.max_points));
}

TEST(Scene, CutsAwayWhatIsHigherThanTheRooms) {
  SmallRun run = smallRun();
  auto raised = std::make_shared<Scan>(*run.graph.keyframes()[1]->scan);
  raised->T_base_lidar = Pose3::translation(0.0, 0.0, 3.0);
  run.graph.keyframes()[1]->scan = raised;
  SceneParams params;
  params.exports.picture.voxel_m = 1e-3;
  EXPECT_EQ(pointCount(run.result(), params), 100u);
}

TEST(Scene, SurvivesFragmentsThatPointOutsideTheScan) {
  SmallRun run = smallRun();
  auto& box = const_cast<CNodeEntity&>(run.graph.getNode<CNodeEntity>({3}));
  box.fragment = {49, 50, 4'000'000'000};
  EXPECT_NO_THROW(exported("3dscene", run.result()));
}

}  // namespace
}  // namespace dynemo::test
