#include "dynemo/pipeline/params.h"

#include <gtest/gtest.h>

#include <cmath>

#include "dynemo/core/config.h"
#include "dynemo/core/error.h"

namespace dynemo {
namespace {

/// Gives every field a value of its own within its range, and remembers it by its path.
class Scramble : public FieldVisitor {
 public:
  void number(const char* key, double& value, const char*, Range range) override {
    value = pick(range);
    remember(key, value);
  }
  void integer(const char* key, int& value, const char*, Range range) override {
    value = static_cast<int>(std::ceil(pick(range)));
    remember(key, value);
  }
  void optionalNumber(const char* key, std::optional<double>& value, const char*,
                      Range range) override {
    value = pick(range);
    remember(key, *value);
  }
  void flag(const char* key, bool& value, const char*) override { remember(key, value = !value); }
  void text(const char* key, std::string& value, const char*) override {
    value = "text " + std::to_string(++count_);
    texts_[path(key)] = value;
  }
  void numbers(const char* key, std::vector<double>& value, const char*) override {
    value = {double(++count_), 0.1};
    remember(key, value[0]);
  }
  void texts(const char* key, std::vector<std::string>& value, const char*) override {
    value = {"a " + std::to_string(++count_), "b"};
    texts_[path(key)] = value[0];
  }
  void table(const char* key, std::map<std::string, std::vector<double>>& value,
             const char*) override {
    value = {{"some label", {double(++count_), -1.5}}};
    remember(key, value.begin()->second[0]);
  }

  std::map<std::string, double> numbers_;
  std::map<std::string, std::string> texts_;

 protected:
  void choiceIndex(const char* key, int& index, const std::vector<std::string>& names,
                   const char*) override {
    index = (index + 1) % static_cast<int>(names.size());
    remember(key, index);
  }
  bool enter(const char* key, const char*) override {
    prefix_.push_back(key);
    return true;
  }
  void leave() override { prefix_.pop_back(); }

 private:
  double pick(Range range) {
    const double share = std::fmod(0.618 * ++count_, 1.0) * 0.9 + 0.05;
    const bool low = std::isfinite(range.min), high = std::isfinite(range.max);
    if (low && high) return range.min + share * (range.max - range.min);
    if (low) return range.min + 1.0 + count_ + share;
    if (high) return range.max - 1.0 - count_ - share;
    return count_ + share;
  }
  std::string path(const char* key) const {
    std::string path;
    for (const auto& part : prefix_) path += part + ".";
    return path + key;
  }
  void remember(const char* key, double value) { numbers_[path(key)] = value; }

  int count_ = 0;
  std::vector<std::string> prefix_;
};

/// Reads every field back.
class Collect : public FieldVisitor {
 public:
  void number(const char* key, double& v, const char*, Range) override { numbers_[path(key)] = v; }
  void integer(const char* key, int& v, const char*, Range) override { numbers_[path(key)] = v; }
  void optionalNumber(const char* key, std::optional<double>& v, const char*, Range) override {
    numbers_[path(key)] = v.value_or(NAN);
  }
  void flag(const char* key, bool& v, const char*) override { numbers_[path(key)] = v; }
  void text(const char* key, std::string& v, const char*) override { texts_[path(key)] = v; }
  void numbers(const char* key, std::vector<double>& v, const char*) override {
    numbers_[path(key)] = v.at(0);
  }
  void texts(const char* key, std::vector<std::string>& v, const char*) override {
    texts_[path(key)] = v.at(0);
  }
  void table(const char* key, std::map<std::string, std::vector<double>>& v, const char*) override {
    numbers_[path(key)] = v.begin()->second.at(0);
  }
  std::map<std::string, double> numbers_;
  std::map<std::string, std::string> texts_;

 protected:
  void choiceIndex(const char* key, int& index, const std::vector<std::string>&,
                   const char*) override {
    numbers_[path(key)] = index;
  }
  bool enter(const char* key, const char*) override {
    prefix_.push_back(key);
    return true;
  }
  void leave() override { prefix_.pop_back(); }

 private:
  std::string path(const char* key) const {
    std::string path;
    for (const auto& part : prefix_) path += part + ".";
    return path + key;
  }
  std::vector<std::string> prefix_;
};

DynemoParams parse(const std::string& yaml) {
  ConfigLoader loader;
  loader.addText(yaml, "test");
  DynemoParams params;
  load(loader, params);
  return params;
}

TEST(Params, DefaultsSurviveTheirOwnText) {
  const std::string yaml = toYaml(DynemoParams());
  EXPECT_EQ(toYaml(parse(yaml)), yaml);
}

TEST(Params, DefaultsAreWithinTheirRanges) { EXPECT_NO_THROW(parse(toYaml(DynemoParams()))); }

TEST(Params, EveryFieldIsOneKeyOfItsOwn) {
  DynemoParams params;
  Scramble scramble;
  fields(scramble, params);
  EXPECT_GT(scramble.numbers_.size(), 100u);
  Collect collect;
  fields(collect, params);
  for (const auto& [key, value] : scramble.numbers_) {
    EXPECT_NEAR(collect.numbers_.at(key), value, 1e-6) << key << " shares its field with another";
  }
  EXPECT_EQ(collect.texts_, scramble.texts_);
}

TEST(Params, EveryFieldIsReadFromItsKey) {
  DynemoParams params;
  Scramble scramble;
  fields(scramble, params);
  DynemoParams read = parse(toYaml(params));
  Collect collect;
  fields(collect, read);
  for (const auto& [key, value] : scramble.numbers_) {
    EXPECT_NEAR(collect.numbers_.at(key), value, 1e-6 * std::max(1.0, std::abs(value))) << key;
  }
  EXPECT_EQ(collect.texts_, scramble.texts_);
}

TEST(Params, AnUnknownSectionAndAnUnknownKeyAreBothReported) {
  try {
    parse("odometri: {source: lidar}\nloops: {enable: true}\n");
    FAIL() << "accepted";
  } catch (const ConfigError& e) {
    const std::string message = e.what();
    EXPECT_NE(message.find("odometri"), std::string::npos);
    EXPECT_NE(message.find("loops.enable"), std::string::npos);
  }
}

}  // namespace
}  // namespace dynemo
