// The generated datasets against the paper's Table II, and whether they can be driven.
#include "dynemo/simulation/datasets.h"

#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <sstream>

#include "dynemo/core/error.h"
#include "dynemo/simulation/collisions.h"
#include "dynemo/simulation/robot_motion.h"
#include "dynemo/simulation/world_file.h"

namespace dynemo::simulation::test {
namespace {

struct Row {
  int agents, objects, moved;
  double area_m2, length_s;
};

/// share/data/paper/datasets.csv:
/// dataset,agents,objects,moved_objects,environment,area_m2,length_s.
std::map<std::string, Row> paperTable() {
  std::ifstream in(std::string(DYNEMO_SOURCE_DIR) + "/share/data/paper/datasets.csv");
  std::map<std::string, Row> rows;
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::istringstream cells(line);
    std::vector<std::string> cell;
    for (std::string text; std::getline(cells, text, ',');) cell.push_back(text);
    rows[cell.at(0)] = {std::stoi(cell.at(1)), std::stoi(cell.at(2)), std::stoi(cell.at(3)),
                        std::stod(cell.at(5)), std::stod(cell.at(6))};
  }
  return rows;
}

TEST(Datasets, HaveThePapersContents) {
  const auto table = paperTable();
  ASSERT_EQ(table.size(), 10u);
  for (const auto& [name, row] : table) {
    SCOPED_TRACE(name);
    const World world = makeDataset(name, {});
    int agents = 0;
    double area_m2 = 0.0;
    for (const Entity& entity : world.entities) agents += entity.isAgent();
    for (const Storey& storey : world.storeys) area_m2 += storey.outline.area();
    EXPECT_EQ(agents, row.agents);
    EXPECT_EQ(static_cast<int>(world.entities.size()) - agents, row.objects);
    EXPECT_EQ(static_cast<int>(world.relocations.size()), row.moved);
    EXPECT_NEAR(area_m2, row.area_m2, 0.5);
    EXPECT_EQ(world.duration_s, row.length_s);
  }
}

class EachDataset : public testing::TestWithParam<std::string> {};

TEST_P(EachDataset, CanBeDrivenAtSeveralSeeds) {
  for (const int seed : {1, 2}) {
    DatasetOptions options;
    options.seed = seed;
    for (const Scale scale : {Scale::kMini, Scale::kFull}) {
      options.scale = scale;
      const World world = parseWorld(worldYaml(makeDataset(GetParam(), options)), GetParam());
      EXPECT_NO_THROW(requireFreeWay(world));
    }
  }
}

TEST_P(EachDataset, DiffersBySeedOnly) {
  DatasetOptions options;
  options.scale = Scale::kMini;
  const std::string first = worldYaml(makeDataset(GetParam(), options));
  EXPECT_EQ(worldYaml(makeDataset(GetParam(), options)), first);
  options.seed = 2;
  EXPECT_NE(worldYaml(makeDataset(GetParam(), options)), first);
}

TEST_P(EachDataset, ChangesHappenAfterTheFirstLapAndBeforeTheEnd) {
  const World world = makeDataset(GetParam(), {});
  const double lap_s = RobotMotion(world.robot, world.seed).lap_s();
  const double explored_s = world.robot.laps > 1 ? lap_s : 0.4 * world.duration_s;
  for (const Relocation& relocation : world.relocations) {
    EXPECT_GE(relocation.time_s, explored_s - 0.1);
    EXPECT_LT(relocation.time_s, 0.9 * world.duration_s);
  }
}

INSTANTIATE_TEST_SUITE_P(All, EachDataset, testing::ValuesIn(datasetNames()), [](const auto& test) {
  std::string name = test.param;
  std::erase(name, '-');
  return name;
});

TEST(Datasets, UnknownNameIsRefusedWithTheKnownOnes) {
  try {
    makeDataset("S-NONE", {});
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("S-SASO"), std::string::npos);
  }
}

TEST(Datasets, ShorterIsABeginningOfTheWholeOne) {
  DatasetOptions options;
  options.scale = Scale::kMini;
  World whole = makeDataset("S-SAMO", options);
  options.duration_s = 10.0;
  const World cut = makeDataset("S-SAMO", options);
  whole.duration_s = 10.0;
  EXPECT_EQ(worldYaml(cut), worldYaml(whole));
}

}  // namespace
}  // namespace dynemo::simulation::test
