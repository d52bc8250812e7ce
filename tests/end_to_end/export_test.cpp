// dynemo-export on the bundled sample, its files judged by readers that are not of this project.
#include <gtest/gtest.h>

#include <map>

#include "dynemo/evaluation/trajectory.h"
#include "dynemo/exporters/exporter.h"
#include "slam_run.h"

namespace dynemo::test {
namespace {

constexpr int kUsage = 2, kData = 3, kMissing = 77;

Outcome exportRun(const fs::path& run, const std::string& format, const fs::path& output,
                  const Arguments& more = {}) {
  Arguments command = {DYNEMO_EXPORT, run, "--format", format, "--output", output};
  command.insert(command.end(), more.begin(), more.end());
  return runCommand(command);
}

/// Exports the bundled run; fails the test when that fails.
fs::path exported(const TemporaryFolder& folder, const std::string& format, const std::string& name,
                  const Arguments& more = {}) {
  const Outcome outcome = exportRun(bundledRun("full").folder(), format, folder / name, more);
  EXPECT_EQ(outcome.status, 0) << describe(outcome);
  EXPECT_TRUE(outcome.out.empty() && outcome.err.empty()) << describe(outcome);
  return folder / name;
}

/// Runs a script of tests/readers; skips the test where what it needs is missing.
void expectAccepted(const Arguments& command) {
  const Outcome outcome = runCommand(command);
  if (outcome.status == kMissing || outcome.status == 127) GTEST_SKIP() << outcome.out;
  EXPECT_EQ(outcome.status, 0) << describe(outcome);
  std::cout << outcome.out;
}

fs::path reader(const std::string& name) {
  return fs::path(DYNEMO_SOURCE_DIR) / "tests" / "readers" / name;
}

bool has(const std::string& program) {
  return runCommand({"sh", "-c", "command -v " + program}).status == 0;
}

TEST(Export, EveryOutputOfARunIsWrittenAgainTheSame) {
  const fs::path run = bundledRun("full").folder();
  const TemporaryFolder folder;
  std::size_t compared = 0;
  for (const std::string& name : exporters().names()) {
    const std::string file = exporters().make(name, ExportParams())->fileName();
    if (!fs::is_regular_file(run / file)) continue;
    EXPECT_TRUE(readBytes(exported(folder, name, file)) == readBytes(run / file)) << name;
    ++compared;
  }
  EXPECT_GE(compared, 7u);
}

TEST(Export, TheFolderOfTheOutputIsMadeOrRefusedBeforehand) {
  const TemporaryFolder folder;
  exported(folder, "keyframes", "made/for/it/k.tum");
  EXPECT_TRUE(fs::exists(folder / "made/for/it/k.tum"));
  writeBytes(folder / "file", "");
  const Outcome refused =
      exportRun(bundledRun("full").folder(), "map", folder / "file" / "map.png");
  EXPECT_EQ(refused.status, kData);
  EXPECT_NE(refused.err.find("file/map.png: cannot be written: Not a directory"), std::string::npos)
      << refused.err;
}

TEST(Export, SlamWritesWhatOutputsName) {
  const TemporaryFolder folder;
  Dataset cut = bundledSample();
  copyRawlog(cut.rawlog(), folder / "cut.rawlog", firstSeconds(3));
  fs::create_directory_symlink(cut.images(), folder / "cut_Images");
  const Outcome outcome = slam({"--entities", cut.entities(), "--output", folder / "run", "--set",
                                "outputs=[ply, pcd, tum, csv, gltf, spark-dsg, html]", "--set",
                                "exports.picture.max_points=1000", "-q", folder / "cut.rawlog"});
  ASSERT_EQ(outcome.status, 0) << describe(outcome);
  for (const char* file : {"map.ply", "map.pcd", "poses/robot.tum", "tables/nodes.csv", "scene.glb",
                           "scene_graph.json", "scene.html"})
    EXPECT_TRUE(fs::exists(folder / "run" / file)) << file;
  EXPECT_FALSE(fs::exists(folder / "run" / "trajectory.tum"));
}

TEST(Export, KhronosValidatorAcceptsGltf) {
  if (!has("node")) GTEST_SKIP() << "no node on this system";
  const TemporaryFolder folder;
  for (const char* name : {"scene.glb", "scene.gltf"}) {
    expectAccepted({"sh", "-c",
                    "NODE_PATH=\"${NODE_PATH:-$(npm root -g 2>/dev/null)}\" node \"$0\" \"$1\"",
                    reader("check_gltf.js"), exported(folder, "gltf", name)});
  }
}

TEST(Export, SparkDsgFollowsItsSchemaAndHoldsTheRun) {
  if (!fs::exists("/usr/bin/python3")) GTEST_SKIP() << "no python3 on this system";
  const TemporaryFolder folder;
  const fs::path run = bundledRun("full").folder();
  expectAccepted({"/usr/bin/python3", reader("check_spark_dsg.py"),
                  exported(folder, "spark-dsg", "scene.json"), run / "entities.csv",
                  run / "keyframes.tum"});
}

TEST(Export, TheWebPageWorksInChromium) {
  if (!fs::exists("/usr/bin/python3")) GTEST_SKIP() << "no python3 on this system";
  const TemporaryFolder folder;
  // Software rendering of the whole map takes its time.
  expectAccepted({"/usr/bin/python3", reader("check_html.py"),
                  exported(folder, "html", "scene.html", {"--set", "picture.max_points=20000"})});
}

TEST(Export, SceneViewerShowsTheScene) {
  for (const char* program : {"SceneViewer3D", "Xvfb", "xdotool", "import"})
    if (!has(program)) GTEST_SKIP() << program << " is not installed";
  const TemporaryFolder folder;
  const Outcome colors = runCommand({DYNEMO_SOURCE_DIR "/tests/end_to_end/scene_viewer_colors.sh",
                                     exported(folder, "3dscene", "scene.3Dscene")});
  EXPECT_EQ(colors.status, 0) << describe(colors);
}

TEST(Export, CloudsShowEntitiesWhereTheyAreAtTheTime) {
  const TemporaryFolder folder;
  const std::string end = readBytes(exported(folder, "ply", "end.ply"));
  const std::string start = readBytes(exported(folder, "ply", "start.ply", {"--at", "+5"}));
  const std::string none =
      readBytes(exported(folder, "ply", "none.ply", {"--set", "cloud.entities=none"}));
  EXPECT_NE(end, start);
  EXPECT_LT(none.size(), end.size());
  EXPECT_EQ(none.find("comment entities as of 17"), end.find("comment entities as of 17"));
}

TEST(Export, TumIsReadByTheEvaluation) {
  const TemporaryFolder folder;
  const fs::path poses = exported(folder, "tum", "poses");
  EXPECT_EQ(readTum(poses / "robot.tum").size(), 131u);
  EXPECT_GT(readTum(poses / "entity_1_box_1.tum").size(), 1u);
}

TEST(Export, IntoAFolderTheFileGetsItsOwnName) {
  const TemporaryFolder folder;
  const Outcome outcome = exportRun(bundledRun("full").folder(), "g2o", folder.path());
  EXPECT_EQ(outcome.status, 0) << describe(outcome);
  EXPECT_TRUE(fs::exists(folder / "graph.g2o"));
}

TEST(Export, AnEarlierExportIsReplacedAndNothingElse) {
  const TemporaryFolder folder;
  const fs::path run = bundledRun("full").folder();
  const fs::path file = exported(folder, "g2o", "graph.g2o");
  writeBytes(file, "old");
  const Outcome again = exportRun(run, "g2o", file);
  EXPECT_EQ(again.out, "replaced    " + file.string() + "\n") << describe(again);
  EXPECT_EQ(readBytes(file), readBytes(run / "graph.g2o"));

  const fs::path poses = exported(folder, "tum", "poses");
  writeBytes(poses / "entity_99_gone.tum", "");
  EXPECT_EQ(exportRun(run, "tum", poses).status, 0);
  EXPECT_FALSE(fs::exists(poses / "entity_99_gone.tum"));
  writeBytes(poses / "thesis.tex", "years of work");
  const Outcome refused = exportRun(run, "tum", poses);
  EXPECT_EQ(refused.status, kData) << describe(refused);
  EXPECT_NE(refused.err.find("thesis.tex"), std::string::npos) << describe(refused);
  EXPECT_EQ(readBytes(poses / "thesis.tex"), "years of work");
}

TEST(Export, RefusesWhatItCannotDo) {
  const TemporaryFolder folder;
  const fs::path run = bundledRun("full").folder();
  const auto expectError = [](const Outcome& outcome, int status, const std::string& text) {
    EXPECT_EQ(outcome.status, status) << describe(outcome);
    EXPECT_NE(outcome.err.find(text), std::string::npos) << describe(outcome);
    EXPECT_EQ(outcome.err.rfind("dynemo-export: ", 0), 0u) << describe(outcome);
  };
  expectError(exportRun(run, "vrml", folder / "x"), kUsage, "vrml: must be among: 3dscene, csv");
  expectError(exportRun(run, "ply", folder / "x", {"--at", "noon"}), kUsage, "--at noon");
  for (const char* far_away : {"30", "+1.7e9"})
    expectError(exportRun(run, "ply", folder / "x", {"--at", far_away}), kUsage,
                "1700000020.000000000 to 1700000072.000000000 (+0 to +52.000)");
  expectError(exportRun(run, "tum", folder / "x", {"--at", "+1"}), kUsage, "shows all times");
  expectError(exportRun(run, "ply", folder / "x", {"--set", "cloud.nope=1"}), kUsage, "cloud.nope");
  writeBytes(folder / "file", "");
  expectError(exportRun(run, "ply", folder / "file" / "x"), kData, "file");
  expectError(exportRun(run, "png", folder / "x.ply"), kUsage, ".ply is written by: ply");
  expectError(exportRun(run, "ply", folder / "x.JPG"), kUsage, "files that end in .ply");
  expectError(exportRun(run, "tum", folder / "x.tum"), kUsage, "format tum writes a folder");
  expectError(exportRun(folder.path(), "ply", folder / "x"), kData, "session/graph.bin");
  EXPECT_FALSE(fs::exists(folder / "x"));
}

TEST(Export, EndingsThatBelongToNoOtherFormatAreTheUsersOwn) {
  for (const auto& [format, file] : std::map<std::string, std::string>{{"ply", "map"},
                                                                       {"pcd", "map.PCD"},
                                                                       {"gltf", "scene.gltf"},
                                                                       {"trajectory", "robot.txt"},
                                                                       {"g2o", "graph.v2"},
                                                                       {"planes", "walls.csv"}})
    EXPECT_NO_THROW(checkFileName(format, file)) << format << " " << file;
}

}  // namespace
}  // namespace dynemo::test
