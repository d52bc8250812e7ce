#include "dynemo/evaluation/entity_data.h"

#include <gtest/gtest.h>

#include "example_run.h"

namespace dynemo::test {
namespace {

constexpr const char* kTruthHeader = "entity_id,class,timestamp,x,y,z,qx,qy,qz,qw\n";

const std::string kEstimateHeader =
    "node_id,entity_id,class,name,timestamp,keyframe_id,moved,x,y,z,qx,qy,qz,qw,first_x,first_y,"
    "first_z,"
    "first_qx,first_qy,first_qz,first_qw\n";

TEST(EntityTruth, ReadsAndSortsByEntityAndStamp) {
  const Folder folder;
  const auto file =
      folder.write("gt.csv", std::string(kTruthHeader) +
                                 "7,object,3.5,1,2,3,0,0,0,1\r\n101,agent,1,0,0,0,0,0,0,1\n"
                                 "7,object,2.5,4,5,6,0,0,0,1\n\n");
  const EntityTruths truths = readEntityTruths(file);
  ASSERT_EQ(truths.size(), 2u);
  EXPECT_EQ(truths.at({101}).semantic_class, SemanticClass::kAgent);
  ASSERT_EQ(truths.at({7}).poses.size(), 2u);
  EXPECT_EQ(truths.at({7}).poses[0].T.t, Vector3(4, 5, 6));
}

TEST(EntityTruth, NamesFileAndLineOfWhatIsWrong) {
  const Folder folder;
  for (const char* bad :
       {"x,object,1,0,0,0,0,0,0,1", "1,ghost,1,0,0,0,0,0,0,1", "1,object,late,0,0,0,0,0,0,1",
        "1,object,1,nan,0,0,0,0,0,1", "1,object,1,0,0,0,0,0,0,0", "1,object,1,0,0,0,0,0,0"}) {
    const auto file = folder.write("gt.csv", std::string(kTruthHeader) + bad + "\n");
    EXPECT_NE(dataError([&] { readEntityTruths(file); }).find("gt.csv:2: "), std::string::npos)
        << bad;
  }
}

TEST(EntityTruth, NamesAMissingColumn) {
  const Folder folder;
  const auto file = folder.write("gt.csv", "entity_id,class,x\n1,object,0\n");
  EXPECT_NE(dataError([&] { readEntityTruths(file); }).find("no column 'timestamp'"),
            std::string::npos);
  const auto empty = folder.write("empty.csv", "");
  EXPECT_NE(dataError([&] { readEntityTruths(empty); }).find("empty.csv"), std::string::npos);
}

TEST(EntityEstimates, ReadQuotedNamesAndFlags) {
  const Folder folder;
  const auto file = folder.write(
      "entities.csv", kEstimateHeader +
                          "4,7,object,\"box, \"\"red\"\"\nbig\",12.25,3,1,1,2,3,0,0,0,1,"
                          "4,5,6,0,0,1,0\n5,7,object,b,x,3,0,1,2,3,0,0,0,1,4,5,6,0,0,1,0\n");
  // The second row is wrong: its line number counts the line break inside the quotes.
  EXPECT_NE(dataError([&] { readEntityEstimates(file); }).find("entities.csv:4: timestamp"),
            std::string::npos);
  const auto good =
      folder.write("good.csv", kEstimateHeader +
                                   "4,7,object,\"box, \"\"red\"\"\",12.25,3,1,1,2,3,0,0,0,1,"
                                   "4,5,6,0,0,1,0\n");
  const auto list = readEntityEstimates(good);
  ASSERT_EQ(list.size(), 1u);
  EXPECT_EQ(list[0].node, NodeId{4});
  EXPECT_EQ(list[0].entity, EntityId{7});
  EXPECT_EQ(list[0].name, "box, \"red\"");
  EXPECT_EQ(list[0].stamp.ns, 12'250'000'000);
  EXPECT_TRUE(list[0].moved);
  EXPECT_FALSE(list[0].covariance);
  EXPECT_EQ(list[0].T_map_entity_first.t, Vector3(4, 5, 6));
}

}  // namespace
}  // namespace dynemo::test
