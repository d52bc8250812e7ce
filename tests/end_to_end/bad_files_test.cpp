// Entity files, configurations and detection tables that cannot be used.
#include <gtest/gtest.h>

#include "slam_run.h"

namespace dynemo::test {
namespace {

constexpr int kUsage = 2, kData = 3;

class BadFile : public testing::Test {
 protected:
  Outcome withFile(const std::string& option, const std::string& name) {
    return slam({option, folder_ / name, "--output", folder_ / "run", bundledSample().rawlog()});
  }
  void expectRefused(const std::string& option, const std::string& name, int status,
                     std::vector<std::string> parts) {
    SCOPED_TRACE(option + " " + name);
    parts.push_back(name);
    expectRefusal(withFile(option, name), status, parts);
    EXPECT_FALSE(fs::exists(folder_ / "run")) << "refused before anything is written";
  }
  void write(const std::string& name, const std::string& text) { writeBytes(folder_ / name, text); }

  TemporaryFolder folder_;
};

TEST_F(BadFile, EntityFiles) {
  const std::string option = "--entities";
  expectRefused(option, "missing.yaml", kUsage, {});
  write("empty.yaml", "");
  expectRefused(option, "empty.yaml", kUsage, {"empty"});
  write("malformed.yaml", "entities: [\n");
  expectRefused(option, "malformed.yaml", kUsage, {"YAML"});
  write("key.yaml", "entities:\n  - {id: 1, class: object, colour: red, tags: []}\n");
  expectRefused(option, "key.yaml", kUsage, {"colour", "unknown key"});
  write("class.yaml", "entities:\n  - {id: 7, class: ghost, tags: []}\n");
  expectRefused(option, "class.yaml", kUsage, {"7", "ghost"});
  write(
      "size.yaml",
      "entities:\n  - {id: 7, class: object, tags: [{id: 3, size: -1, pose: [0,0,0,0,0,0,1]}]}\n");
  expectRefused(option, "size.yaml", kUsage, {"7", "size", "-1"});
  write("twice.yaml",
        "entities:\n  - {id: 7, class: object, tags: []}\n  - {id: 7, class: agent, tags: []}\n");
  expectRefused(option, "twice.yaml", kUsage, {"7"});
  fs::create_directory(folder_ / "folder.yaml");
  expectRefused(option, "folder.yaml", kUsage, {});
}

TEST_F(BadFile, Configurations) {
  const std::string option = "--config";
  expectRefused(option, "missing.yaml", kUsage, {"cannot be read"});
  write("empty.yaml", "");
  expectRefused(option, "empty.yaml", kUsage, {"empty"});
  write("malformed.yaml", "keyframes: {timer: true\n");
  expectRefused(option, "malformed.yaml", kUsage, {"YAML"});
  write("list.yaml", "- 1\n- 2\n");
  expectRefused(option, "list.yaml", kUsage, {"table of keys"});
  write("key.yaml", "keyframes:\n  timmer: true\n");
  expectRefused(option, "key.yaml", kUsage, {"keyframes.timmer", "unknown key"});
  write("bytes.yaml", std::string("\x00\x01\xff\xfe: \x80", 8));
  expectRefused(option, "bytes.yaml", kUsage, {});
  fs::create_directory(folder_ / "folder.yaml");
  expectRefused(option, "folder.yaml", kUsage, {"cannot be read"});
}

TEST_F(BadFile, DetectionTables) {
  const std::string option = "--detections";
  expectRefused(option, "missing.csv", kData, {"no such file"});
  write("empty.csv", "");
  expectRefused(option, "empty.csv", kData, {"empty"});
  write("header.csv", "timestamp,entity_id,class,x,y,z,qx,qy,qz,qw\n");
  expectRefused(option, "header.csv", kData, {"no usable detection"});
  write("short.csv", "1700000021,1,object,1,2,3\n");
  expectRefused(option, "short.csv", kData, {"line 1", "6 fields"});
  write("nan.csv", "1700000021,1,object,nan,2,3,0,0,0,1\n");
  expectRefused(option, "nan.csv", kData, {"line 1", "nan"});
}

TEST_F(BadFile, MalformedDetectionsAmongGoodOnesAreCounted) {
  write("some.csv",
        "1700000021,1,object,1,0,0,0,0,0,1\nnonsense\n1700000022,1,object,inf,0,0,0,0,0,1\n"
        "1700000023,1,object,1,0,0,0,0,0,1\n");
  const Outcome run = slam({"--detections", folder_ / "some.csv", "--output", folder_ / "run"});
  ASSERT_EQ(run.status, 0) << describe(run);
  const nlohmann::json summary = readJson(folder_ / "run" / "summary.json");
  EXPECT_EQ(warningCount(summary, "malformed line"), 2u);
  EXPECT_EQ(warningCount(summary, "line 2"), 2u) << "names the first";
  EXPECT_EQ(summary.at("frames"), 2);
}

}  // namespace
}  // namespace dynemo::test
