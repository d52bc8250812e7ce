#include "dynemo/graph/session.h"

#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <random>
#include <sstream>

#include "dynemo/core/error.h"
#include "dynemo/graph/edge_relative_pose.h"
#include "dynemo/graph/types.h"

namespace dynemo {
namespace {

namespace fs = std::filesystem;

std::string bytesOf(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

void overwrite(const fs::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary | std::ios::trunc) << bytes;
}

class SessionTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() /
              ("dynemo_session_" +
               std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
    session_.config_yaml = "keyframes:\n  timer: false\n";
    session_.graph.T_map_odom = Pose3::fromYawPitchRoll(0.1, 0.2, 0.3, 0.4, 0.5, 0.6);
    std::mt19937_64 rng(4);
    GraphDelta delta;
    for (std::uint64_t i = 0; i < 3; ++i) {
      auto keyframe = std::make_shared<CNodeKeyframe>();
      keyframe->id = {i};
      keyframe->T_map_node = randomPose(rng);
      keyframe->stamp = {1'700'000'000'000'000'000 + static_cast<std::int64_t>(i)};
      if (i != 1) keyframe->scan = scan(static_cast<int>(i) + 2);
      delta.nodes.push_back(keyframe);
    }
    auto edge = CEdgeOdometry::example(rng);
    edge->nodes = {{0}, {2}};
    delta.edges.push_back(edge);
    session_.graph.apply(delta);
    session_.frames = {{{5}, randomPose(rng), randomPose(rng)}, {{7}, Pose3(), randomPose(rng)}};
    session_.entity_covariances[{2}] = randomInformation(6, rng);
    session_.plane_covariances[{1}] = randomInformation(3, rng);
    session_.keyframes_without_closures = {randomPose(rng), randomPose(rng), randomPose(rng)};
  }
  void TearDown() override { fs::remove_all(folder_); }

  static std::shared_ptr<const Scan> scan(int points) {
    auto s = std::make_shared<Scan>();
    s->stamp = {42};
    s->T_base_lidar = Pose3::translation(0, 0, 0.5);
    for (int i = 0; i < points; ++i) {
      s->cloud.points.emplace_back(0.1F * static_cast<float>(i), 1.0F, -2.0F);
      s->cloud.time_offset_s.push_back(0.01F * static_cast<float>(i));
    }
    return s;
  }
  std::string loadError() const {
    try {
      loadSession(folder_);
    } catch (const DataError& e) {
      return e.what();
    }
    return "";
  }

  fs::path folder_;
  Session session_;
};

TEST_F(SessionTest, LoadsBackWithCloudsAndDrift) {
  saveSession(session_, folder_);
  const Session loaded = loadSession(folder_);
  EXPECT_EQ(loaded.config_yaml, session_.config_yaml);
  EXPECT_EQ(loaded.graph.nodeCount(), 3u);
  EXPECT_EQ(loaded.graph.edgeCount(), 1u);
  EXPECT_EQ(local(loaded.graph.T_map_odom, session_.graph.T_map_odom).norm(), 0.0);
  EXPECT_FALSE(loaded.graph.keyframes()[1]->scan);
  ASSERT_TRUE(loaded.graph.keyframes()[2]->scan);
  EXPECT_EQ(loaded.graph.keyframes()[2]->scan->cloud.points,
            session_.graph.keyframes()[2]->scan->cloud.points);
  EXPECT_EQ(loaded.graph.keyframes()[2]->scan->cloud.time_offset_s.size(), 4u);
}

TEST_F(SessionTest, LoadsBackFramesAndCovariancesExactly) {
  saveSession(session_, folder_);
  const Session loaded = loadSession(folder_);
  ASSERT_EQ(loaded.frames.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(loaded.frames[i].stamp, session_.frames[i].stamp);
    EXPECT_EQ(loaded.frames[i].T_odom_base.R, session_.frames[i].T_odom_base.R);
    EXPECT_EQ(loaded.frames[i].T_map_base.t, session_.frames[i].T_map_base.t);
  }
  EXPECT_EQ(loaded.entity_covariances, session_.entity_covariances);
  EXPECT_EQ(loaded.plane_covariances, session_.plane_covariances);
  ASSERT_EQ(loaded.keyframes_without_closures.size(), 3u);
  EXPECT_EQ(loaded.keyframes_without_closures[2].t, session_.keyframes_without_closures[2].t);
}

TEST_F(SessionTest, ASessionWithoutPosesHasTheGraph) {
  saveSession(session_, folder_);
  fs::remove(folder_ / "poses.bin");
  const Session loaded = loadSession(folder_);
  EXPECT_EQ(loaded.graph.nodeCount(), 3u);
  EXPECT_TRUE(loaded.frames.empty());
  EXPECT_TRUE(loaded.entity_covariances.empty());
}

TEST_F(SessionTest, SavingWhatWasLoadedGivesTheSameBytes) {
  saveSession(session_, folder_);
  const fs::path again = folder_ / "again";
  saveSession(loadSession(folder_), again);
  for (const char* file :
       {"graph.bin", "poses.bin", "config.yaml", "clouds/000000.bin", "clouds/000002.bin"}) {
    EXPECT_EQ(bytesOf(folder_ / file), bytesOf(again / file)) << file;
  }
}

TEST_F(SessionTest, EveryTruncationIsAnErrorThatNamesTheFile) {
  saveSession(session_, folder_);
  for (const char* name : {"graph.bin", "poses.bin", "clouds/000002.bin"}) {
    const std::string whole = bytesOf(folder_ / name);
    for (std::size_t length = 0; length < whole.size(); length += 7) {
      overwrite(folder_ / name, whole.substr(0, length));
      EXPECT_NE(loadError().find(fs::path(name).filename().string()), std::string::npos)
          << name << " cut at " << length;
    }
    overwrite(folder_ / name, whole);
  }
  EXPECT_EQ(loadError(), "");
}

TEST_F(SessionTest, FlippedBytesNeverCrash) {
  saveSession(session_, folder_);
  std::mt19937 rng(9);
  for (const char* name : {"graph.bin", "poses.bin"}) {
    const std::string whole = bytesOf(folder_ / name);
    for (int i = 0; i < 300; ++i) {
      std::string damaged = whole;
      damaged[rng() % damaged.size()] = static_cast<char>(rng());
      overwrite(folder_ / name, damaged);
      EXPECT_NO_FATAL_FAILURE(loadError());
    }
    overwrite(folder_ / name, whole);
  }
}

TEST_F(SessionTest, MissingFilesAreNamed) {
  saveSession(session_, folder_);
  fs::remove(folder_ / "clouds" / "000002.bin");
  EXPECT_NE(loadError().find("000002.bin"), std::string::npos);
  EXPECT_THROW(loadSession(folder_ / "nowhere"), DataError);
}

TEST_F(SessionTest, AnUnwritableFolderIsAnError) {
  std::ofstream(folder_) << "a file is in the way";
  EXPECT_THROW(saveSession(session_, folder_), DataError);
}

TEST_F(SessionTest, AHeaderOfAbsurdLengthIsAnError) {
  saveSession(session_, folder_);
  for (const char* name : {"graph.bin", "poses.bin", "clouds/000002.bin"}) {
    const std::string whole = bytesOf(folder_ / name);
    overwrite(folder_ / name, "\xff\xff\xff\xff" + whole.substr(4));
    EXPECT_NE(loadError().find("not plausible"), std::string::npos) << loadError();
    overwrite(folder_ / name, whole);
  }
}

TEST_F(SessionTest, ADamagedCloudIsAnErrorThatNamesTheFile) {
  auto damaged = std::make_shared<Scan>(*scan(3));
  const auto save = [&] {
    session_.graph.setScan({2}, damaged);
    saveSession(session_, folder_);
  };
  damaged->cloud.points[1].x() = std::numeric_limits<float>::quiet_NaN();
  save();
  EXPECT_NE(loadError().find("000002.bin: is damaged: a stored point is not finite"),
            std::string::npos);
  *damaged = *scan(3);
  damaged->cloud.time_offset_s.pop_back();
  save();
  EXPECT_NE(loadError().find("000002.bin: is damaged: not one attribute per point"),
            std::string::npos);
  *damaged = *scan(3);
  damaged->cloud.row = damaged->cloud.column = {0, 1, 2};
  damaged->cloud.rows = 3;
  damaged->cloud.columns = 2;
  save();
  EXPECT_NE(loadError().find("000002.bin: is damaged: a stored point lies outside"),
            std::string::npos);
}

TEST_F(SessionTest, AFullDiskIsAnErrorAndLeavesTheEarlierGraph) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full on this system";
  saveSession(session_, folder_);
  const std::string before = bytesOf(folder_ / "graph.bin");
  fs::create_symlink("/dev/full", folder_ / "graph.bin.part");
  session_.graph.T_map_odom = Pose3();
  EXPECT_THROW(saveSession(session_, folder_), DataError);
  EXPECT_EQ(bytesOf(folder_ / "graph.bin"), before);
}

}  // namespace
}  // namespace dynemo
