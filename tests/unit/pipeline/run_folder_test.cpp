#include "dynemo/pipeline/run_folder.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "dynemo/core/config.h"
#include "dynemo/core/error.h"
#include "dynemo/graph/session.h"
#include "frames.h"

namespace dynemo {
namespace {

namespace fs = std::filesystem;

constexpr int kFrames = 30;

std::string read(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream bytes;
  bytes << in.rdbuf();
  return bytes.str();
}

std::size_t lines(const fs::path& file) {
  const std::string text = read(file);
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

/// Limits the size of files, as a full disk would, while it lives.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : old_handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &old_limit_);
    const rlimit limit{bytes, old_limit_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &old_limit_);
    std::signal(SIGXFSZ, old_handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  void (*old_handler_)(int);
  rlimit old_limit_{};
};

class RunFolderTest : public testing::Test {
 protected:
  RunFolderTest() : pipeline_(test::externalOnly(), models_, true) {
    std::string name = (fs::temp_directory_path() / "dynemo_run_folder_XXXXXX").string();
    EXPECT_NE(mkdtemp(name.data()), nullptr);
    temporary_ = name;
    folder_ = temporary_ / "some" / "run";
    params_ = test::externalOnly();
    ingest_.frames = kFrames;
    ingest_.warnings["something dropped"] = 3;
    ingest_.observations["lidar (class)"] = 9;
  }
  ~RunFolderTest() override { fs::remove_all(temporary_); }

  void drive() {
    test::driveWithWrongScale(pipeline_, kFrames);
    pipeline_.finish();
  }
  nlohmann::json json(const std::string& name) const {
    return nlohmann::json::parse(read(folder_ / name));
  }
  std::string failure(RunFolder& run) {
    try {
      run.results(pipeline_, ingest_, identity_);
    } catch (const DataError& e) {
      return e.what();
    }
    return "";
  }

  EntityModels models_;
  SlamPipeline pipeline_;
  fs::path temporary_, folder_;
  DynemoParams params_;
  IngestReport ingest_;
  RunIdentity identity_{"1.2.3", "some setup", "some.rawlog"};
};

TEST_F(RunFolderTest, BeginsWithTheConfigurationAndEmptyLogs) {
  const RunFolder run(folder_, params_);
  EXPECT_EQ(read(folder_ / "config.yaml"), toYaml(params_));
  EXPECT_EQ(read(folder_ / "log.txt"), "");
  EXPECT_EQ(lines(folder_ / "timing.csv"), 1u);
  EXPECT_EQ(lines(folder_ / "optimizations.csv"), 1u);
}

TEST_F(RunFolderTest, LogsGrowLineByLine) {
  RunFolder run(folder_, params_);
  run.log("first");
  EXPECT_EQ(read(folder_ / "log.txt"), "first\n");
  FrameTiming timing;
  timing[Stage::kDetection] = 1.5;
  timing[Stage::kMapping] = 2.25;
  run.frame(4, test::at(0.5), timing);
  const std::string csv = read(folder_ / "timing.csv");
  EXPECT_NE(
      csv.find("4,1000.500000000,0.000,0.000,1.500,0.000,0.000,0.000,2.250,0.000,0.000,3.750\n"),
      std::string::npos)
      << csv;
}

TEST_F(RunFolderTest, OptimisationsAreAppendedOnce) {
  drive();
  RunFolder run(folder_, params_);
  run.optimizations(pipeline_.optimizations());
  run.optimizations(pipeline_.optimizations());
  EXPECT_EQ(lines(folder_ / "optimizations.csv"), 1 + pipeline_.optimizations().size());
}

TEST_F(RunFolderTest, AllConfiguredOutputsAreWritten) {
  drive();
  RunFolder run(folder_, params_);
  run.results(pipeline_, ingest_, identity_);
  for (const char* name : {"trajectory.tum", "keyframes.tum", "odometry.tum", "entities.csv",
                           "graph.g2o", "graph.graph", "scene.3Dscene", "summary.json"})
    EXPECT_GT(fs::file_size(folder_ / name), 0u) << name;
  EXPECT_EQ(lines(folder_ / "trajectory.tum"), static_cast<std::size_t>(kFrames));
  const Session session = loadSession(folder_ / "session");
  EXPECT_EQ(session.graph.nodeCount(), pipeline_.graph().nodeCount());
  EXPECT_EQ(session.config_yaml, toYaml(params_));
}

TEST_F(RunFolderTest, TheSummaryTellsWhatHappened) {
  drive();
  RunFolder run(folder_, params_);
  run.results(pipeline_, ingest_, identity_);
  const nlohmann::json summary = json("summary.json");
  EXPECT_EQ(summary.at("version"), "1.2.3");
  EXPECT_EQ(summary.at("setup"), "some setup");
  EXPECT_EQ(summary.at("rawlog"), "some.rawlog");
  EXPECT_EQ(summary.at("frames"), kFrames);
  EXPECT_EQ(summary.at("observations").at("lidar (class)"), 9);
  EXPECT_EQ(summary.at("warnings").at("something dropped"), 3);
  const std::size_t keyframes = pipeline_.graph().keyframes().size();
  EXPECT_EQ(summary.at("keyframes").at("count"), keyframes);
  EXPECT_EQ(summary.at("keyframes").at("reasons").at("first"), 1);
  EXPECT_EQ(summary.at("graph").at("nodes").at("keyframe"), keyframes);
  EXPECT_EQ(summary.at("graph").at("edges").at("odometry"), keyframes - 1);
  ASSERT_EQ(summary.at("entities").size(), 1u);
  const auto& box = summary.at("entities").at(0);
  EXPECT_EQ(box.at("id"), 7);
  EXPECT_EQ(box.at("class"), "object");
  EXPECT_EQ(box.at("observations"), pipeline_.graph().tracks().at({7}).size());
  EXPECT_EQ(box.at("moved"), false);
  EXPECT_NEAR(box.at("T_map_entity").at("position_m").at(0).get<double>(), 10.0, 0.05);
  EXPECT_EQ(summary.at("T_map_odom").at("sigma").size(), 6u);
}

TEST_F(RunFolderTest, ACheckpointWritesTheLightResultsOnly) {
  test::driveWithWrongScale(pipeline_, kFrames);
  RunFolder run(folder_, params_);
  run.checkpoint(pipeline_, ingest_, identity_);
  EXPECT_EQ(lines(folder_ / "trajectory.tum"), static_cast<std::size_t>(kFrames));
  EXPECT_TRUE(fs::exists(folder_ / "summary.json"));
  EXPECT_TRUE(fs::exists(folder_ / "entities.csv"));
  for (const char* heavy : {"scene.3Dscene", "session", "graph.g2o"})
    EXPECT_FALSE(fs::exists(folder_ / heavy)) << heavy;
}

TEST_F(RunFolderTest, ACheckpointKeepsToTheConfiguredOutputs) {
  test::driveWithWrongScale(pipeline_, kFrames);
  params_.outputs = {"keyframes"};
  RunFolder run(folder_, params_);
  run.checkpoint(pipeline_, ingest_, identity_);
  EXPECT_TRUE(fs::exists(folder_ / "keyframes.tum"));
  EXPECT_FALSE(fs::exists(folder_ / "trajectory.tum"));
}

TEST_F(RunFolderTest, PerformanceSummarisesTheStages) {
  RunFolder run(folder_, params_);
  for (int i = 1; i <= 100; ++i) {
    FrameTiming timing;
    timing[Stage::kOdometry] = i;
    run.frame(static_cast<std::uint64_t>(i), test::at(i), timing);
  }
  run.performance({2.0, 1.5, 10.0, 64.0});
  const nlohmann::json performance = json("performance.json");
  EXPECT_EQ(performance.at("frames"), 100);
  EXPECT_EQ(performance.at("real_time_factor"), 5.0);
  EXPECT_EQ(performance.at("cpu_s"), 1.5);
  EXPECT_EQ(performance.at("peak_rss_mb"), 64.0);
  const auto& odometry = performance.at("stages").at("odometry");
  EXPECT_EQ(odometry.at("mean_ms"), 50.5);
  EXPECT_EQ(odometry.at("p95_ms"), 96.0);
  EXPECT_EQ(odometry.at("max_ms"), 100.0);
}

TEST_F(RunFolderTest, UnknownOutputsAreRefusedBeforeAnythingIsWritten) {
  params_.outputs = {"trajectory", "nonsense"};
  try {
    RunFolder run(folder_, params_);
    FAIL() << "accepted";
  } catch (const ConfigError& e) {
    const std::string message = e.what();
    for (const char* part : {"outputs", "nonsense", "trajectory", "session"})
      EXPECT_NE(message.find(part), std::string::npos) << part;
  }
  EXPECT_FALSE(fs::exists(folder_));
}

TEST_F(RunFolderTest, AFileInTheWayIsRefused) {
  fs::create_directories(folder_.parent_path());
  std::ofstream(folder_) << "mine";
  EXPECT_THROW(RunFolder(folder_, params_), DataError);
  EXPECT_EQ(read(folder_), "mine");
}

TEST_F(RunFolderTest, EveryFailureIsListedAndTheRestIsWritten) {
  drive();
  RunFolder run(folder_, params_);
  fs::create_directories(folder_ / "keyframes.tum" / "in the way");
  fs::create_directories(folder_ / "graph.g2o" / "in the way");
  const std::string message = failure(run);
  EXPECT_NE(message.find("keyframes.tum"), std::string::npos) << message;
  EXPECT_NE(message.find("graph.g2o"), std::string::npos) << message;
  EXPECT_EQ(message.find("trajectory.tum"), std::string::npos) << message;
  for (const char* name : {"trajectory.tum", "entities.csv", "summary.json", "session/graph.bin"})
    EXPECT_TRUE(fs::exists(folder_ / name)) << name;
}

TEST_F(RunFolderTest, AFullDiskIsNoticedByEveryFile) {
  drive();
  params_.outputs = {"trajectory", "keyframes", "odometry", "entities", "g2o", "graph", "session"};
  RunFolder run(folder_, params_);
  std::string message;
  {
    const FileSizeLimit limit(100);
    message = failure(run);
    EXPECT_THROW(run.log(std::string(1000, 'x')), DataError);
    EXPECT_THROW(run.performance({}), DataError);
  }
  for (const char* name : {"trajectory.tum", "keyframes.tum", "odometry.tum", "entities.csv",
                           "graph.g2o", "graph.graph", "session", "summary.json"}) {
    EXPECT_NE(message.find(name), std::string::npos) << name << " in: " << message;
    EXPECT_FALSE(fs::is_regular_file(folder_ / name)) << name;
  }
  for (const auto& entry : fs::recursive_directory_iterator(folder_))
    EXPECT_NE(entry.path().extension(), ".part") << entry.path();
  EXPECT_EQ(failure(run), "") << "and space that comes back is used";
}

}  // namespace
}  // namespace dynemo
