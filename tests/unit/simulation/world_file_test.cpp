#include "dynemo/simulation/world_file.h"

#include <gtest/gtest.h>

#include "dynemo/core/error.h"
#include "dynemo/simulation/datasets.h"
#include "small_world.h"

namespace dynemo::simulation::test {
namespace {

TEST(WorldFile, ReadsBackWhatItWrites) {
  for (const std::string& name : datasetNames()) {
    DatasetOptions options;
    options.scale = Scale::kMini;
    const std::string written = worldYaml(makeDataset(name, options));
    EXPECT_EQ(worldYaml(parseWorld(written, name)), written);
  }
}

TEST(WorldFile, ReadsEveryKey) {
  const World world = smallWorld();
  ASSERT_EQ(world.storeys.size(), 1u);
  EXPECT_EQ(world.storeys[0].walls.size(), 5u);
  EXPECT_EQ(world.storeys[0].walls[4].doors.at(0).at_m, 2.5);
  EXPECT_EQ(world.storeys[0].furniture[1].model, "shelf");
  ASSERT_EQ(world.entities.size(), 3u);
  EXPECT_TRUE(world.findEntity(101)->isAgent());
  EXPECT_EQ(world.entities[1].tag_ids, (std::vector<int>{4, 5, 6, 7}));
  EXPECT_EQ(world.relocations.front().entity, 2) << "by time";
  EXPECT_EQ(world.relocations.front().duration_s, 1.5);
  EXPECT_EQ(world.robot.route[1].wait_s, 0.5);
  EXPECT_EQ(world.sensors.lidar.rings, 16);
  EXPECT_EQ(world.sensors.camera.fx, 460.0);
}

struct BadFile {
  const char* name;
  std::string text;
  std::vector<std::string> parts;
};

class BadWorldFile : public testing::TestWithParam<BadFile> {};

TEST_P(BadWorldFile, IsRefusedWithAMessageThatSaysWhatAndWhere) {
  try {
    parseWorld(GetParam().text, "file.yaml");
    FAIL() << "not refused";
  } catch (const ConfigError& error) {
    const std::string message = error.what();
    EXPECT_EQ(message.find("file.yaml"), 0u) << message;
    for (const std::string& part : GetParam().parts)
      EXPECT_NE(message.find(part), std::string::npos) << message << "\nlacks: " << part;
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, BadWorldFile,
    testing::Values(
        BadFile{"Empty", "", {"is empty"}}, BadFile{"NotYaml", "a: [1", {"not YAML"}},
        BadFile{"AList", "[1, 2]", {"must be a mapping"}},
        BadFile{"UnknownKey", changed("seed: 3", "sed: 3"), {"unknown key 'sed'"}},
        BadFile{"NoDuration", changed("duration_s: 4\n", ""), {"lacks the key 'duration_s'"}},
        BadFile{
            "NegativeDuration", changed("duration_s: 4", "duration_s: -4"), {"duration_s", "-4"}},
        BadFile{"PathAsName", changed("name: small", "name: a/b"), {"name", "file name"}},
        BadFile{
            "WallWithoutLength", changed("to: [8, 0]", "to: [0, 0]"), {"ground", "wall 0", "to"}},
        BadFile{
            "DoorBeyondWall", changed("{at: 2.5, ", "{at: 4.9, "), {"wall 4", "door 0", "beyond"}},
        BadFile{"UnknownFurniture",
                changed("model: shelf", "model: piano"),
                {"item 1", "piano", "cabinet"}},
        BadFile{
            "UnknownEntity", changed("model: chair", "model: cat"), {"entity 2", "cat", "human"}},
        BadFile{
            "RepeatedId", changed("id: 2, model: chair", "id: 1, model: chair"), {"id 1", "twice"}},
        BadFile{"RepeatedTag", changed("[4, 5, 6, 7]", "[4, 5, 6, 3]"), {"tag 3", "1 and 2"}},
        BadFile{"TooFewTags", changed("[4, 5, 6, 7]", "[4, 5]"), {"entity 2", "4 elements"}},
        BadFile{"TagBeyondFamily", changed("[4, 5, 6, 7]", "[4, 5, 6, 587]"), {"587", "586"}},
        BadFile{
            "AgentWithoutPath",
            changed("path: {from: [3.9, 3.2], to: [3.9, 4.2], speed: 0.6, turn_s: 1, phase_s: 0.4}",
                    "yaw_deg: 0"),
            {"entity 101", "path"}},
        BadFile{"MovedAgent", changed("{entity: 1,", "{entity: 101,"), {"relocation 0", "agent"}},
        BadFile{"MovedNobody", changed("{entity: 1,", "{entity: 9,"), {"relocation 0", "9"}},
        BadFile{"EmptyRoute",
                changed("route:\n    - {at: [1.0, 2.5]}\n    - {at: [6.0, 2.5], wait_s: 0.5}\n    "
                        "- {at: [6.0, 1.2]}",
                        "route: []"),
                {"route"}},
        BadFile{
            "UnknownCarrier", changed("carrier: wheels", "carrier: wings"), {"carrier", "wings"}},
        BadFile{"NotANumber", changed("speed: 0.8", "speed: fast"), {"robot", "speed", "fast"}},
        BadFile{"UnknownSensorKey", changed("rings: 16", "ring: 16"), {"sensors", "ring"}},
        BadFile{"SensorOutOfRange", changed("rings: 16", "rings: 0"), {"sensors", "rings", "0"}}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(BadWorldFile, MissingFileIsNamed) {
  EXPECT_THROW(readWorld("/nowhere/world.yaml"), ConfigError);
}

}  // namespace
}  // namespace dynemo::simulation::test
