// Rawlogs that are missing, damaged or cut short: one clear message or a counted warning, never a
// crash or a hang.
#include <gtest/gtest.h>

#include <random>

#include "dynemo/evaluation/trajectory.h"
#include "slam_run.h"

namespace dynemo::test {
namespace {

constexpr int kData = 3;
constexpr std::chrono::seconds kPatience{20};

class BadRawlog : public testing::Test {
 protected:
  /// A run on NAME.rawlog in the test's folder, whose images are the bundled sample's.
  Outcome run(const std::string& name, const Arguments& more = {}) {
    return slam(slamCommand({folder_.path(), name}, folder_ / "run", more), {}, kPatience);
  }
  void write(const std::string& name, const std::string& bytes) {
    writeBytes(folder_ / (name + ".rawlog"), bytes);
    link(name);
  }
  void link(const std::string& name) {
    const Dataset d = bundledSample(), here{folder_.path(), name};
    if (fs::exists(fs::symlink_status(here.entities()))) return;
    fs::create_directory_symlink(d.images(), here.images());
    fs::create_symlink(d.entities(), here.entities());
  }
  nlohmann::json summary() const { return readJson(folder_ / "run" / "summary.json"); }

  TemporaryFolder folder_;
};

TEST_F(BadRawlog, Missing) {
  link("missing");
  expectRefusal(run("missing"), kData, {"missing.rawlog", "no such file"});
  EXPECT_FALSE(fs::exists(folder_ / "run"));
}

TEST_F(BadRawlog, Empty) {
  write("empty", "");
  expectRefusal(run("empty"), kData, {"empty.rawlog", "empty"});
}

TEST_F(BadRawlog, AFolder) {
  link("folder");
  fs::create_directory(folder_ / "folder.rawlog");
  expectRefusal(run("folder"), kData, {"folder.rawlog", "folder"});
}

TEST_F(BadRawlog, RandomBytes) {
  std::mt19937 rng(1);
  for (const std::size_t size : {1u, 100u, 100000u}) {
    std::string bytes(size, '\0');
    for (char& byte : bytes) byte = static_cast<char>(rng());
    write("random", bytes);
    expectRefusal(run("random"), kData, {"random.rawlog", "no MRPT rawlog"});
    write("random", "\x1f\x8b\x08" + bytes);
    expectRefusal(run("random"), kData, {"random.rawlog", "no usable"});
  }
}

TEST_F(BadRawlog, ATextFile) {
  write("text", readBytes(bundledSample().entities()));
  expectRefusal(run("text"), kData, {"text.rawlog", "no MRPT rawlog: it is text"});
}

TEST_F(BadRawlog, CutShortBeforeAnythingUsable) {
  const std::string whole = readBytes(bundledSample().rawlog());
  for (const std::size_t size : {1u, 10u, 100u}) {
    write("short", whole.substr(0, size));
    expectRefusal(run("short"), kData, {"short.rawlog"});
  }
}

TEST_F(BadRawlog, CutShortKeepsWhatCameBefore) {
  const std::string whole = readBytes(bundledSample().rawlog());
  std::size_t frames_before = 0;
  for (const double share : {0.05, 0.2, 0.5}) {
    SCOPED_TRACE(share);
    write("short",
          whole.substr(0, static_cast<std::size_t>(share * static_cast<double>(whole.size()))));
    const Outcome outcome = run("short");
    ASSERT_EQ(outcome.status, 0) << describe(outcome);
    EXPECT_NE(outcome.out.find("damaged"), std::string::npos) << "shown at the end";
    EXPECT_EQ(warningCount(summary(), "damaged"), 1u);
    const std::size_t frames = readTum(folder_ / "run" / "trajectory.tum").size();
    EXPECT_GT(frames, frames_before);
    EXPECT_NEAR(static_cast<double>(frames), share * 131, 10);
    frames_before = frames;
  }
}

/// Flips one to eight bits. Half of the damage hits the bytes around a class name, where lengths
/// and versions are, the rest any byte.
std::string damaged(std::string bytes, std::mt19937& rng) {
  std::vector<std::size_t> names;
  for (auto at = bytes.find("CObservation"); at != std::string::npos;
       at = bytes.find("CObservation", at + 1))
    names.push_back(at);
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(rng()) % n; };
  const bool structure = !names.empty() && below(2) == 0;
  const std::size_t flips = 1 + below(8);
  for (std::size_t i = 0; i < flips; ++i) {
    const std::size_t at =
        structure ? names[below(names.size())] + below(120) : below(bytes.size());
    bytes[std::min(at, bytes.size() - 1)] ^= static_cast<char>(1 << below(8));
  }
  return bytes;
}

class FlippedBits : public BadRawlog, public testing::WithParamInterface<bool> {};

TEST_P(FlippedBits, EndInResultsOrOneMessage) {
  constexpr unsigned kSeed = 2024;
  constexpr int kMutations = 24;
  const bool compressed = GetParam();
  copyRawlog(bundledSample().rawlog(), folder_ / "good.rawlog", firstSeconds(2.5), compressed);
  const std::string good = readBytes(folder_ / "good.rawlog");
  std::mt19937 rng(kSeed);
  int with_results = 0, changed = 0;
  for (int i = 0; i < kMutations; ++i) {
    SCOPED_TRACE("seed " + std::to_string(kSeed) + ", mutation " + std::to_string(i));
    write("flipped", damaged(good, rng));
    const Outcome outcome = run("flipped");
    EXPECT_FALSE(outcome.timed_out);
    if (outcome.status == 0) {
      ++with_results;
      EXPECT_GT(readTum(folder_ / "run" / "trajectory.tum").size(), 0u);
      changed += !summary().at("warnings").empty();
    } else {
      expectRefusal(outcome, kData, {"flipped.rawlog"});
    }
  }
  EXPECT_GT(with_results, 0) << "most damage leaves something to use";
  EXPECT_GT(changed, 0) << "and is told of";
}

INSTANTIATE_TEST_SUITE_P(Rawlog, FlippedBits, testing::Bool(),
                         [](const auto& test) { return test.param ? "compressed" : "plain"; });

class Images : public BadRawlog {
 protected:
  static constexpr double kSeconds = 4.0;
  static constexpr std::uint64_t kImages = 10;
  void SetUp() override {
    copyRawlog(bundledSample().rawlog(), folder_ / "cut.rawlog", firstSeconds(kSeconds));
  }
  /// A folder of links to the images, to be damaged.
  fs::path linkedImages() {
    const fs::path images = folder_ / "cut_Images";
    fs::create_directory(images);
    for (const auto& entry : fs::directory_iterator(bundledSample().images()))
      fs::create_symlink(entry.path(), images / entry.path().filename());
    return images;
  }
};

TEST_F(Images, AllMissingAreCounted) {
  fs::create_symlink(bundledSample().entities(), folder_ / "cut_entities.yaml");
  const Outcome outcome = run("cut");
  ASSERT_EQ(outcome.status, 0) << describe(outcome);
  EXPECT_EQ(warningCount(summary(), "image file not found"), kImages);
  EXPECT_EQ(readTum(folder_ / "run" / "trajectory.tum").size(), kImages) << "the scans remain";
}

TEST_F(Images, SomeMissingOrDamagedAreCounted) {
  const fs::path images = linkedImages();
  fs::create_symlink(bundledSample().entities(), folder_ / "cut_entities.yaml");
  fs::remove(images / "camera_1700000020.400000.jpg");
  const std::string jpeg = readBytes(images / "camera_1700000021.200000.jpg");
  for (const auto& [name, bytes] :
       {std::pair{"camera_1700000021.200000.jpg", jpeg.substr(0, 100)},
        std::pair{"camera_1700000021.600000.jpg", std::string()},
        std::pair{"camera_1700000022.000000.jpg", std::string(5000, 'x')}}) {
    fs::remove(images / name);
    writeBytes(images / name, bytes);
  }
  const Outcome outcome = run("cut");
  ASSERT_EQ(outcome.status, 0) << describe(outcome);
  EXPECT_EQ(warningCount(summary(), "image file not found"), 1u);
  EXPECT_EQ(warningCount(summary(), "image of 'camera'"), 4u);
  EXPECT_FALSE(summary().at("entities").empty()) << "the other images are used";
}

}  // namespace
}  // namespace dynemo::test
