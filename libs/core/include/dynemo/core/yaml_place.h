// Reading lists and mappings of YAML by hand, with messages that say where a wrong value is. For
// parameters that are fixed keys with defaults see config.h.
#pragma once

#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <string_view>

#include "dynemo/core/error.h"

namespace dynemo {

/// A node together with the words that say where it is: "file: entity 3: tag 46: size".
class YamlPlace {
 public:
  YamlPlace(YAML::Node node, std::string where)
      : node_(std::move(node)), where_(std::move(where)) {}

  /// Throws ConfigError when the file cannot be read, is empty or is not YAML.
  static YamlPlace file(const std::filesystem::path& file) {
    std::ifstream in(file);
    std::stringstream text;
    if (!in || std::filesystem::is_directory(file) || !(text << in.rdbuf()))
      throw ConfigError(file.string() + ": cannot be read or is empty");
    return YamlPlace::text(text.str(), file.string());
  }
  /// Throws ConfigError when the text is not YAML; `origin` names it in messages.
  static YamlPlace text(const std::string& yaml, const std::string& origin) {
    try {
      return {YAML::Load(yaml), origin};
    } catch (const YAML::Exception& error) {
      throw ConfigError(origin + ": not YAML: " + error.what());
    }
  }

  [[noreturn]] void fail(const std::string& constraint) const {
    std::string value;
    if (node_.IsDefined() && node_.IsScalar()) value = " '" + node_.Scalar() + "'";
    throw ConfigError(where_ + ":" + value + " " + constraint);
  }

  const YAML::Node& node() const { return node_; }
  const std::string& where() const { return where_; }
  bool isNull() const { return !node_.IsDefined() || node_.IsNull(); }
  std::size_t size() const { return node_.size(); }

  YamlPlace named(const std::string& name) const { return {node_, where_ + ": " + name}; }
  bool has(const char* key) const { return node_[key].IsDefined(); }
  YamlPlace at(const char* key) const {
    if (!has(key)) fail(std::string("lacks the key '") + key + "'");
    return {node_[key], where_ + ": " + key};
  }
  YamlPlace at(std::size_t i) const {
    return {node_[i], where_ + ": element " + std::to_string(i)};
  }

  /// A mapping with no other and no repeated keys.
  void expectMap(std::initializer_list<std::string_view> allowed) const {
    if (isNull() || !node_.IsMap()) fail("must be a mapping");
    std::set<std::string> seen;
    for (const auto& entry : node_) {
      if (!entry.first.IsScalar()) fail("has a key that is not a word");
      const std::string key = entry.first.Scalar();
      if (std::find(allowed.begin(), allowed.end(), key) == allowed.end()) {
        fail("unknown key '" + key + "'");
      }
      if (!seen.insert(key).second) fail("key '" + key + "' is given twice");
    }
  }

  void expectSequence(std::optional<std::size_t> size = std::nullopt) const {
    if (isNull() || !node_.IsSequence()) fail("must be a list");
    if (size && node_.size() != *size) {
      fail("must have " + std::to_string(*size) + " elements, has " + std::to_string(node_.size()));
    }
  }

  template <class T>
  T as(const char* kind) const {
    if (!node_.IsDefined() || !node_.IsScalar()) fail(std::string("must be ") + kind);
    try {
      return node_.as<T>();
    } catch (const YAML::Exception&) {
      fail(std::string("must be ") + kind);
    }
  }

  /// Finite.
  double number() const {
    const double value = as<double>("a number");
    if (!std::isfinite(value)) fail("must be finite");
    return value;
  }

  std::string word() const {
    const std::string value = as<std::string>("a text");
    if (value.empty()) fail("must not be empty");
    return value;
  }

  template <int N>
  Eigen::Matrix<double, N, 1> vector() const {
    expectSequence(N);
    Eigen::Matrix<double, N, 1> v;
    for (int i = 0; i < N; ++i) v[i] = at(static_cast<std::size_t>(i)).number();
    return v;
  }

 private:
  YAML::Node node_;
  std::string where_;
};

}  // namespace dynemo
