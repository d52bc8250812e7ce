#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "dynemo/core/error.h"
#include "dynemo/perception/entity_model.h"

namespace dynemo {
namespace {

constexpr double kTolerance = 1e-9;

class EntityFile : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    std::string name = std::string(test->test_suite_name()) + test->name() + ".yaml";
    for (char& c : name) c = c == '/' ? '_' : c;
    file_ = std::filesystem::temp_directory_path() / name;
  }
  void TearDown() override { std::filesystem::remove(file_); }

  EntityModels load(const std::string& text) {
    std::ofstream(file_) << text;
    return EntityModels::load(file_);
  }

  /// The message of the ConfigError, or "" when there was none.
  std::string errorOf(const std::string& text) {
    try {
      load(text);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  }

  std::filesystem::path file_;
};

const char* const kGood = R"(
tag_family: tag36h11
entities:
  - id: 7
    class: agent
    model: human
    motion_model: agent_line
    origin_z: 1.0
    prior_direction: [1, 0, 0]
    tags:
      - {id: 5, size: 0.2, side: front, pose: [0.1, 0, 0.2, -0.5, -0.5, 0.5, 0.5],
         corners: [[0.1, -0.1, 0.1], [0.1, 0.1, 0.1], [0.1, 0.1, 0.3], [0.1, -0.1, 0.3]]}
  - {id: 3, name: my chair, class: object}
)";

TEST_F(EntityFile, ReadsEveryKey) {
  const EntityModels models = load(kGood);
  ASSERT_EQ(models.all().size(), 2U);
  const EntityModel& agent = *models.findEntity(EntityId{7});
  EXPECT_EQ(agent.name, "human 7");
  EXPECT_EQ(agent.semantic_class, SemanticClass::kAgent);
  EXPECT_EQ(agent.motion_model, "agent_line");
  EXPECT_EQ(agent.origin_height_m, 1.0);
  EXPECT_LT((*agent.direction_entity - Vector3::UnitX()).norm(), kTolerance);
  const auto [owner, tag] = models.findTag(5);
  EXPECT_EQ(owner, &agent);
  EXPECT_EQ(tag->size_m, 0.2);
  EXPECT_LT((tag->corners()[0] - Vector3(0.1, -0.1, 0.1)).norm(), kTolerance);
  EXPECT_LT((tag->corners()[2] - Vector3(0.1, 0.1, 0.3)).norm(), kTolerance);
  EXPECT_EQ(models.findEntity(EntityId{3})->name, "my chair");
  EXPECT_TRUE(models.findEntity(EntityId{3})->tags.empty());
  EXPECT_EQ(models.findEntity(EntityId{4}), nullptr);
  EXPECT_EQ(models.findTag(6).first, nullptr);
}

TEST_F(EntityFile, AnExplicitlyEmptyListIsAllowed) {
  EXPECT_TRUE(load("entities: []\n").empty());
  EXPECT_EQ(load("tag_family: tagStandard41h12\nentities: []\n").tagFamily(), "tagStandard41h12");
}

TEST_F(EntityFile, AMissingFileOrAFolderIsAnError) {
  EXPECT_THROW(EntityModels::load(file_), ConfigError);
  EXPECT_THROW(EntityModels::load(std::filesystem::temp_directory_path()), ConfigError);
}

struct BadFile {
  const char* name;
  const char* text;
  std::vector<const char*> message_parts;
};

class BadEntityFile : public EntityFile, public ::testing::WithParamInterface<BadFile> {};

TEST_P(BadEntityFile, IsRefusedWithPlaceAndConstraint) {
  const std::string message = errorOf(GetParam().text);
  ASSERT_FALSE(message.empty()) << "no error";
  EXPECT_NE(message.find(file_.string()), std::string::npos) << message;
  for (const char* part : GetParam().message_parts) {
    EXPECT_NE(message.find(part), std::string::npos) << message;
  }
}

#define ENTITY(text) "entities:\n  - {" text "}\n"
#define TAG(text) ENTITY("id: 4, class: object, tags: [{" text "}]")
#define POSE "pose: [0, 0, 0, 0, 0, 0, 1]"

INSTANTIATE_TEST_SUITE_P(
    Files, BadEntityFile,
    ::testing::Values(
        BadFile{"Empty", "", {"empty"}},  //
        BadFile{"OnlyComment", "# nothing\n", {"empty"}},
        BadFile{"NotYaml", "entities: [\n  {]", {"YAML"}},
        BadFile{"Scalar", "hello\n", {"mapping"}},
        BadFile{"NoEntities", "tag_family: tag36h11\n", {"entities"}},
        BadFile{"NullEntities", "entities:\n", {"entities", "list"}},
        BadFile{"UnknownTopKey", "entities: []\ncolour: red\n", {"unknown key 'colour'"}},
        BadFile{"UnknownFamily", "tag_family: tag99\nentities: []\n", {"tag99", "tag36h11"}},
        BadFile{"UnknownEntityKey", ENTITY("id: 4, class: object, speed: 3"), {"'speed'"}},
        BadFile{"RepeatedKey", ENTITY("id: 4, class: object, id: 5"), {"'id'", "twice"}},
        BadFile{"NoId", ENTITY("class: object"), {"'id'"}},
        BadFile{"TextId", ENTITY("id: four, class: object"), {"id", "four", "integer"}},
        BadFile{"NegativeId", ENTITY("id: -4, class: object"), {"-4", "≥ 0"}},
        BadFile{"NoClass", ENTITY("id: 4"), {"entity 4", "'class'"}},
        BadFile{"UnknownClass", ENTITY("id: 4, class: cat"), {"entity 4", "class", "cat"}},
        BadFile{"DuplicateEntity",
                "entities:\n  - {id: 4, class: object}\n  - {id: 4, class: agent}\n",
                {"entity 4", "twice"}},
        BadFile{"BadHeight", ENTITY("id: 4, class: object, origin_z: high"), {"origin_z", "high"}},
        BadFile{
            "NaNHeight", ENTITY("id: 4, class: object, origin_z: .nan"), {"origin_z", "finite"}},
        BadFile{"DirectionNotUnit",
                ENTITY("id: 4, class: agent, prior_direction: [2, 0, 0]"),
                {"entity 4", "prior_direction", "unit"}},
        BadFile{"DirectionTooShort",
                ENTITY("id: 4, class: agent, prior_direction: [1, 0]"),
                {"prior_direction", "3"}},
        BadFile{
            "EmptyMotionModel", ENTITY("id: 4, class: agent, motion_model: ''"), {"motion_model"}},
        BadFile{"TagsNotAList", ENTITY("id: 4, class: object, tags: 5"), {"tags", "list"}},
        BadFile{"UnknownTagKey", TAG("id: 1, size: 0.2, colour: red, " POSE), {"'colour'"}},
        BadFile{"NoTagId", TAG("size: 0.2, " POSE), {"entity 4", "'id'"}},
        BadFile{"TagIdOutsideOfFamily", TAG("id: 587, size: 0.2, " POSE), {"587", "586"}},
        BadFile{"NoSize", TAG("id: 1, " POSE), {"entity 4", "tag 1", "'size'"}},
        BadFile{"ZeroSize", TAG("id: 1, size: 0, " POSE), {"entity 4", "tag 1", "size", "> 0"}},
        BadFile{"NegativeSize", TAG("id: 1, size: -0.2, " POSE), {"size", "-0.2"}},
        BadFile{"NoPose", TAG("id: 1, size: 0.2"), {"'pose'"}},
        BadFile{"ShortPose", TAG("id: 1, size: 0.2, pose: [0, 0, 0]"), {"pose", "7"}},
        BadFile{"PoseNotUnit",
                TAG("id: 1, size: 0.2, pose: [0, 0, 0, 0, 0, 0, 2]"),
                {"pose", "unit quaternion"}},
        BadFile{"PoseNotFinite",
                TAG("id: 1, size: 0.2, pose: [.inf, 0, 0, 0, 0, 0, 1]"),
                {"pose", "finite"}},
        BadFile{"CornersContradict",
                TAG("id: 1, size: 0.2, " POSE
                    ", corners: [[-0.1, 0.1, 0], [0.1, 0.1, 0], [0.1, -0.1, 0], [-0.1, -0.2, 0]]"),
                {"tag 1", "corners", "contradicts"}},
        BadFile{"DuplicateTag",
                ENTITY("id: 4, class: object, tags: [{id: 1, size: 0.2, " POSE
                       "}, {id: 1, size: 0.2, " POSE "}]"),
                {"tag 1", "entity 4"}}),
    [](const auto& file) { return file.param.name; });

#undef ENTITY
#undef TAG
#undef POSE

}  // namespace
}  // namespace dynemo
