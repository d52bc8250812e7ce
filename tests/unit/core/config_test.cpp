#include "dynemo/core/config.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "dynemo/core/error.h"

namespace dynemo::test {
namespace {

enum class Mode { kFast, kExact };

struct InnerParams {
  double ratio = 0.5;
  int count = 3;
};
void fields(FieldVisitor& v, InnerParams& p) {
  v.number("ratio", p.ratio, "Some ratio", Range::between(0.0, 1.0));
  v.integer("count", p.count, "Some count", {1, 10});
}

struct OuterParams {
  double length_m = 1.25;
  double angle_rad = 0.3;
  bool enabled = true;
  std::string name = "base";
  Mode mode = Mode::kFast;
  std::vector<double> list = {1.0, 2.0};
  std::vector<std::string> labels = {"a"};
  std::map<std::string, std::vector<double>> rows;
  std::optional<double> limit;
  InnerParams inner;
};
void fields(FieldVisitor& v, OuterParams& p) {
  v.number("length_m", p.length_m, "Some length", Range::positive());
  v.angle("angle_deg", p.angle_rad, "Some angle", Range::between(0.0, 180.0));
  v.flag("enabled", p.enabled, "Some switch");
  v.text("name", p.name, "Some name");
  v.choice("mode", p.mode, {"fast", "exact"}, "Some mode");
  v.numbers("list", p.list, "Some numbers");
  v.texts("labels", p.labels, "Some names");
  v.table("rows", p.rows, "Some rows");
  v.optionalNumber("limit", p.limit, "Some limit", Range::nonNegative());
  v.section("inner", p.inner, "Some section");
}

OuterParams loaded(const std::string& yaml) {
  ConfigLoader loader;
  loader.addText(yaml, "text");
  OuterParams p;
  load(loader, p);
  return p;
}

std::string complaint(const ConfigLoader& loader) {
  OuterParams p;
  try {
    load(loader, p);
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "";
}

std::string complaint(const std::string& yaml) {
  ConfigLoader loader;
  loader.addText(yaml, "file.yaml");
  return complaint(loader);
}

#define EXPECT_CONTAINS(text, part) \
  EXPECT_NE(std::string(text).find(part), std::string::npos) << (text)

TEST(Config, WhatNoLayerNamesKeepsItsValue) {
  const OuterParams p = loaded("length_m: 2");
  EXPECT_EQ(p.length_m, 2.0);
  EXPECT_EQ(p.name, "base");
  EXPECT_EQ(p.inner.count, 3);
}

TEST(Config, ReadsEveryType) {
  const OuterParams p = loaded(
      "{length_m: 1e-3, angle_deg: 90, enabled: false, name: x y, mode: exact, list: [3], labels: "
      "[b, c],"
      " rows: {lidar: [1, 2, 3]}, limit: 7, inner: {ratio: 0.25, count: 9}}");
  EXPECT_EQ(p.length_m, 1e-3);
  EXPECT_NEAR(p.angle_rad, std::numbers::pi / 2, 1e-15);
  EXPECT_FALSE(p.enabled);
  EXPECT_EQ(p.name, "x y");
  EXPECT_EQ(p.mode, Mode::kExact);
  EXPECT_EQ(p.list, std::vector<double>{3.0});
  EXPECT_EQ(p.labels, (std::vector<std::string>{"b", "c"}));
  EXPECT_EQ(p.rows.at("lidar"), (std::vector<double>{1, 2, 3}));
  EXPECT_EQ(p.limit, 7.0);
  EXPECT_EQ(p.inner.ratio, 0.25);
  EXPECT_EQ(p.inner.count, 9);
}

TEST(Config, LaterLayersWin) {
  ConfigLoader loader;
  loader.addText("{length_m: 2, inner: {count: 4}}", "first");
  loader.addText("inner: {ratio: 0.125, count: 5}", "second");
  loader.addOverride("inner.count=6");
  OuterParams p;
  load(loader, p);
  EXPECT_EQ(p.length_m, 2.0);
  EXPECT_EQ(p.inner.ratio, 0.125);
  EXPECT_EQ(p.inner.count, 6);
}

TEST(Config, NullSwitchesAnOptionalOff) {
  ConfigLoader loader;
  loader.addText("limit: 3", "first");
  loader.addText("limit: null", "second");
  OuterParams p;
  load(loader, p);
  EXPECT_FALSE(p.limit);
}

TEST(Config, UnknownKeysAreErrorsAtEveryLevel) {
  EXPECT_CONTAINS(complaint("lenght_m: 2"), "lenght_m");
  EXPECT_CONTAINS(complaint("inner: {ratios: 1}"), "inner.ratios");
  EXPECT_CONTAINS(complaint("lenght_m: 2"), "unknown key");
  ConfigLoader loader;
  loader.addOverride("inner.missing=1");
  EXPECT_CONTAINS(complaint(loader), "inner.missing");
}

TEST(Config, OutOfRangeNamesFileKeyValueAndConstraint) {
  const std::string text = complaint("inner: {ratio: 1.5}");
  for (const char* part : {"file.yaml", "inner.ratio", "1.5", "[0, 1]"})
    EXPECT_CONTAINS(text, part);
  EXPECT_CONTAINS(complaint("length_m: 0"), "> 0");
  EXPECT_CONTAINS(complaint("angle_deg: 181"), "[0, 180]");
  EXPECT_CONTAINS(complaint("limit: -1"), ">= 0");
  EXPECT_CONTAINS(complaint("mode: quick"), "fast, exact");
  EXPECT_CONTAINS(complaint("inner: {count: 0}"), "[1, 10]");
}

TEST(Config, WrongTypesAreErrors) {
  for (const char* yaml :
       {"length_m: long", "length_m: .nan", "length_m: [1]", "enabled: perhaps", "inner: 3",
        "inner: [1]", "inner: {count: 2.5}", "list: 3", "list: [a]", "list: [.inf]", "rows: [1]",
        "rows: {a: b}", "labels: {a: 1}", "name: [a]", "mode: [fast]", "limit: high"}) {
    EXPECT_NE(complaint(std::string(yaml)), "") << yaml;
  }
}

TEST(Config, AllViolationsAreReportedTogether) {
  ConfigLoader loader;
  loader.addText("{length_m: -1, inner: {ratio: 2}}", "first.yaml");
  loader.addText("{nonsense: 1}", "second.yaml");
  loader.addOverride("mode=slow");
  const std::string text = complaint(loader);
  for (const char* part : {"length_m", "inner.ratio", "nonsense", "mode", "first.yaml",
                           "second.yaml", "--set", "4 "}) {
    EXPECT_CONTAINS(text, part);
  }
}

TEST(Config, BrokenTextsNameTheirOrigin) {
  ConfigLoader loader;
  for (const char* yaml :
       {"", "# only a comment", "[1, 2]", "just text", "a: [1", "a: b: c", "\t- x"}) {
    try {
      loader.addText(yaml, "broken.yaml");
      ADD_FAILURE() << "accepted: " << yaml;
    } catch (const ConfigError& e) {
      EXPECT_CONTAINS(e.what(), "broken.yaml");
    }
  }
  EXPECT_THROW(loader.addFile("/nonexistent/file.yaml"), ConfigError);
  EXPECT_THROW(loader.addFile("/"), ConfigError);
  for (const char* set : {"", "=3", "length_m", "list=[1"})
    EXPECT_THROW(loader.addOverride(set), ConfigError) << set;
}

TEST(Config, KeysThatAreNoPathsAreErrorsNotCrashes) {
  for (const char* set :
       {".=1", "..a=1", "inner.=1", "inner..count=1", "a.b.c.d=1", "length_m.x=2"}) {
    ConfigLoader loader;
    try {
      loader.addOverride(set);
    } catch (const ConfigError&) {
      continue;
    }
    EXPECT_NE(complaint(loader), "") << set;
  }
}

TEST(Config, ReadsFiles) {
  const auto file = std::filesystem::temp_directory_path() / "dynemo_config_test.yaml";
  std::ofstream(file) << "length_m: 4\n";
  ConfigLoader loader;
  loader.addFile(file);
  OuterParams p;
  load(loader, p);
  std::filesystem::remove(file);
  EXPECT_EQ(p.length_m, 4.0);
}

TEST(Config, AnglesSurviveADumpExactly) {
  for (double deg = 0.0; deg <= 180.0; deg += 0.37) {
    OuterParams p;
    p.angle_rad = deg * std::numbers::pi / 180.0;
    EXPECT_NEAR(loaded(toYaml(p)).angle_rad, p.angle_rad, 1e-14 * std::max(1.0, p.angle_rad))
        << deg;
    const OuterParams once = loaded(toYaml(p));
    EXPECT_EQ(toYaml(once), toYaml(p));
  }
}

TEST(Config, UntouchedAnglesKeepEveryBit) {
  OuterParams p;
  p.angle_rad = 0.123456789012345678;
  ConfigLoader loader;
  loader.addText("length_m: 1", "text");
  load(loader, p);
  EXPECT_EQ(p.angle_rad, 0.123456789012345678);
}

TEST(Config, DumpLoadsBackToTheSameValues) {
  OuterParams p;
  p.length_m = 0.1 + 0.2;
  p.enabled = false;
  p.name = "a: b # c";
  p.mode = Mode::kExact;
  p.list = {1.0 / 3.0, -1e-300, 1e22};
  p.labels = {"yes", "1", "two words", "true"};
  p.rows = {{"left camera", {0.1, 0.2}}, {"", {}}};
  p.limit = 1e-9;
  p.inner = {1.0 / 7.0, 10};
  for (const bool documented : {true, false}) {
    const OuterParams q = loaded(toYaml(p, documented));
    EXPECT_EQ(q.length_m, p.length_m);
    EXPECT_EQ(q.enabled, p.enabled);
    EXPECT_EQ(q.name, p.name);
    EXPECT_EQ(q.mode, p.mode);
    EXPECT_EQ(q.list, p.list);
    EXPECT_EQ(q.labels, p.labels);
    EXPECT_EQ(q.rows, p.rows);
    EXPECT_EQ(q.limit, p.limit);
    EXPECT_EQ(q.inner.ratio, p.inner.ratio);
    EXPECT_EQ(q.inner.count, p.inner.count);
    EXPECT_EQ(toYaml(q, documented), toYaml(p, documented));
  }
}

TEST(Config, DocumentationGoesWithTheKeys) {
  const std::string text = toYaml(OuterParams());
  for (const char* part : {"# Some length (> 0)", "# Some ratio (in [0, 1])",
                           "# Some mode (fast | exact)", "limit: null"}) {
    EXPECT_CONTAINS(text, part);
  }
  EXPECT_EQ(toYaml(OuterParams(), false).find('#'), std::string::npos);
}

TEST(Config, EmptyAndOddTextsSurviveADump) {
  for (const char* name :
       {"", " ", "null", "~", "1.5", "yes", "'", "\"", "- a", "multi\nline", "ünï"}) {
    OuterParams p;
    p.name = name;
    EXPECT_EQ(loaded(toYaml(p)).name, name);
  }
}

}  // namespace
}  // namespace dynemo::test
