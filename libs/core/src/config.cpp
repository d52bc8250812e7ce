#include "dynemo/core/config.h"

#include <yaml-cpp/yaml.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <numbers>
#include <set>
#include <sstream>

#include "dynemo/core/error.h"

namespace dynemo {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

std::string shortestNumber(double value) {
  if (std::isnan(value)) return ".nan";
  if (std::isinf(value)) return value < 0 ? "-.inf" : ".inf";
  char buffer[32];
  for (int digits = 6; digits <= 17; ++digits) {
    std::snprintf(buffer, sizeof(buffer), "%.*g", digits, value);
    if (std::strtod(buffer, nullptr) == value) break;
  }
  return buffer;
}

std::string oneLine(const YAML::Node& node) {
  YAML::Emitter out;
  out << YAML::Flow << node;
  return out.c_str();
}

/// Reads one layer into the fields; what it finds wrong goes to `problems`.
class YamlReader : public FieldVisitor {
 public:
  YamlReader(const YAML::Node& root, std::string origin, std::vector<std::string>& problems)
      : origin_(std::move(origin)), problems_(problems) {
    levels_.push_back({root, "", {}});
  }

  void number(const char* key, double& value, const char*, Range range) override {
    if (const auto node = find(key)) readNumber(*node, key, value, range);
  }
  void optionalNumber(const char* key, std::optional<double>& value, const char*,
                      Range range) override {
    const auto node = find(key);
    if (!node) return;
    if (node->IsNull()) {
      value.reset();
      return;
    }
    double v = value.value_or(0.0);
    if (readNumber(*node, key, v, range)) value = v;
  }
  void integer(const char* key, int& value, const char*, Range range) override {
    const auto node = find(key);
    if (!node) return;
    int v{};
    if (!node->IsScalar() || !YAML::convert<int>::decode(*node, v))
      return complain(key, *node, "expected an integer");
    if (!range.contains(v)) return complain(key, *node, "must be " + range.text());
    value = v;
  }
  void flag(const char* key, bool& value, const char*) override {
    const auto node = find(key);
    if (!node) return;
    bool v{};
    if (!node->IsScalar() || !YAML::convert<bool>::decode(*node, v))
      return complain(key, *node, "expected true or false");
    value = v;
  }
  void text(const char* key, std::string& value, const char*) override {
    const auto node = find(key);
    if (!node) return;
    if (node->IsNull()) {
      value.clear();
    } else if (!node->IsScalar()) {
      complain(key, *node, "expected a text");
    } else {
      value = node->Scalar();
    }
  }
  void numbers(const char* key, std::vector<double>& value, const char*) override {
    const auto node = find(key);
    if (!node) return;
    std::vector<double> list;
    if (readList(*node, list)) {
      value = std::move(list);
    } else {
      complain(key, *node, "expected a list of numbers");
    }
  }
  void texts(const char* key, std::vector<std::string>& value, const char*) override {
    const auto node = find(key);
    if (!node) return;
    std::vector<std::string> list;
    if (node->IsScalar()) {
      list.push_back(node->Scalar());
    } else if (node->IsSequence()) {
      for (const auto& item : *node) {
        if (!item.IsScalar()) return complain(key, *node, "expected a list of names");
        list.push_back(item.Scalar());
      }
    } else if (!node->IsNull()) {
      return complain(key, *node, "expected a list of names");
    }
    value = std::move(list);
  }
  void table(const char* key, std::map<std::string, std::vector<double>>& value,
             const char*) override {
    const auto node = find(key);
    if (!node) return;
    if (node->IsNull()) return value.clear();
    if (!node->IsMap()) return complain(key, *node, "expected a table of named number lists");
    for (const auto& item : *node) {
      std::vector<double> list;
      if (!item.first.IsScalar() || !readList(item.second, list)) {
        return complain(key, item.second, "expected a list of numbers");
      }
      value[item.first.Scalar()] = std::move(list);
    }
  }

  /// Reports the keys that no field asked for.
  void finish() { reportUnknown(levels_.back()); }

 protected:
  void choiceIndex(const char* key, int& index, const std::vector<std::string>& names,
                   const char*) override {
    const auto node = find(key);
    if (!node) return;
    std::string allowed;
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (node->IsScalar() && node->Scalar() == names[i]) {
        index = static_cast<int>(i);
        return;
      }
      allowed += (i ? ", " : "") + names[i];
    }
    complain(key, *node, "must be one of: " + allowed);
  }
  bool enter(const char* key, const char*) override {
    const auto node = find(key);
    if (!node || node->IsNull()) return false;
    if (!node->IsMap()) {
      complain(key, *node, "expected a section with keys");
      return false;
    }
    levels_.push_back({*node, path(key) + ".", {}});
    return true;
  }
  void leave() override {
    reportUnknown(levels_.back());
    levels_.pop_back();
  }

 private:
  struct Level {
    YAML::Node node;
    std::string prefix;
    std::set<std::string> asked;
  };

  std::string path(const std::string& key) const { return levels_.back().prefix + key; }

  std::optional<YAML::Node> find(const char* key) {
    Level& level = levels_.back();
    level.asked.insert(key);
    const YAML::Node& map = level.node;  // const: the non-const [] would insert the key
    if (!map.IsMap()) return std::nullopt;
    YAML::Node child = map[key];
    if (!child.IsDefined()) return std::nullopt;
    return child;
  }
  bool readNumber(const YAML::Node& node, const char* key, double& value, const Range& range) {
    double v{};
    if (!node.IsScalar() || !YAML::convert<double>::decode(node, v) || std::isnan(v)) {
      complain(key, node, "expected a number");
      return false;
    }
    if (!range.contains(v)) {
      complain(key, node, "must be " + range.text());
      return false;
    }
    value = v;
    return true;
  }
  static bool readList(const YAML::Node& node, std::vector<double>& list) {
    if (node.IsNull()) return true;
    if (!node.IsSequence()) return false;
    for (const auto& item : node) {
      double v{};
      if (!item.IsScalar() || !YAML::convert<double>::decode(item, v) || !std::isfinite(v))
        return false;
      list.push_back(v);
    }
    return true;
  }
  void complain(const std::string& key, const YAML::Node& node, const std::string& constraint) {
    problems_.push_back(origin_ + ": " + path(key) + ": " + oneLine(node) + ": " + constraint);
  }
  void reportUnknown(const Level& level) {
    if (!level.node.IsMap()) return;
    for (const auto& item : level.node) {
      const std::string key = item.first.IsScalar() ? item.first.Scalar() : oneLine(item.first);
      if (!level.asked.contains(key))
        problems_.push_back(origin_ + ": " + level.prefix + key + ": unknown key");
    }
  }

  std::string origin_;
  std::vector<std::string>& problems_;
  std::vector<Level> levels_;
};

/// Writes fields line by line; yaml-cpp's emitter cannot place a comment before a key.
class YamlWriter : public FieldVisitor {
 public:
  explicit YamlWriter(bool documented) : documented_(documented) {}

  void number(const char* key, double& value, const char* doc, Range range) override {
    line(key, shortestNumber(value), doc, range.text());
  }
  void optionalNumber(const char* key, std::optional<double>& value, const char* doc,
                      Range range) override {
    const std::string allowed = range.text();
    line(key, value ? shortestNumber(*value) : "null", doc,
         allowed.empty() ? "or null" : allowed + ", or null");
  }
  void integer(const char* key, int& value, const char* doc, Range range) override {
    line(key, std::to_string(value), doc, range.text());
  }
  void flag(const char* key, bool& value, const char* doc) override {
    line(key, value ? "true" : "false", doc, "");
  }
  void text(const char* key, std::string& value, const char* doc) override {
    line(key, quoted(value), doc, "");
  }
  void numbers(const char* key, std::vector<double>& value, const char* doc) override {
    line(key, list(value), doc, "");
  }
  void texts(const char* key, std::vector<std::string>& value, const char* doc) override {
    std::string s = "[";
    for (std::size_t i = 0; i < value.size(); ++i) s += (i ? ", " : "") + quoted(value[i]);
    line(key, s + "]", doc, "");
  }
  void table(const char* key, std::map<std::string, std::vector<double>>& value,
             const char* doc) override {
    if (value.empty()) return line(key, "{}", doc, "");
    line(key, "", doc, "");
    for (const auto& [name, row] : value)
      out_ << indent() << "  " << quoted(name) << ": " << list(row) << "\n";
  }

  std::string str() const { return out_.str(); }

 protected:
  void choiceIndex(const char* key, int& index, const std::vector<std::string>& names,
                   const char* doc) override {
    std::string allowed;
    for (std::size_t i = 0; i < names.size(); ++i) allowed += (i ? " | " : "") + names[i];
    line(key, names.at(static_cast<std::size_t>(index)), doc, allowed);
  }
  bool enter(const char* key, const char* doc) override {
    if (documented_ && depth_ == 0 && out_.tellp() > 0) out_ << "\n";
    line(key, "", doc, "");
    ++depth_;
    return true;
  }
  void leave() override { --depth_; }

 private:
  std::string indent() const { return std::string(static_cast<std::size_t>(2 * depth_), ' '); }
  void line(const char* key, const std::string& value, const char* doc,
            const std::string& allowed) {
    if (documented_ && doc && *doc) {
      out_ << indent() << "# " << doc << (allowed.empty() ? "" : " (" + allowed + ")") << "\n";
    }
    out_ << indent() << key << ":" << (value.empty() ? "" : " " + value) << "\n";
  }
  static std::string quoted(const std::string& s) {
    YAML::Emitter out;
    if (s.empty()) return "\"\"";
    out << s;
    return out.c_str();
  }
  static std::string list(const std::vector<double>& values) {
    std::string s = "[";
    for (std::size_t i = 0; i < values.size(); ++i)
      s += (i ? ", " : "") + shortestNumber(values[i]);
    return s + "]";
  }

  bool documented_;
  int depth_ = 0;
  std::ostringstream out_;
};

}  // namespace

std::string Range::text() const {
  const bool has_min = std::isfinite(min), has_max = std::isfinite(max);
  if (has_min && has_max) return "in [" + shortestNumber(min) + ", " + shortestNumber(max) + "]";
  if (has_min) return (min_excluded ? "> " : ">= ") + shortestNumber(min);
  if (has_max) return "<= " + shortestNumber(max);
  return "";
}

void FieldVisitor::angle(const char* key_deg, double& value_rad, const char* doc, Range range_deg) {
  // Through decimal degrees and back must not change an untouched value.
  const double before_deg = std::round(value_rad / kDegree * 1e9) / 1e9;
  double value_deg = before_deg;
  number(key_deg, value_deg, doc, range_deg);
  if (value_deg != before_deg) value_rad = value_deg * kDegree;
}

struct ConfigLoader::Impl {
  struct Layer {
    YAML::Node root;
    std::string origin;
  };
  std::vector<Layer> layers;
};

ConfigLoader::ConfigLoader() : impl_(std::make_unique<Impl>()) {}
ConfigLoader::~ConfigLoader() = default;

void ConfigLoader::addFile(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in || std::filesystem::is_directory(file)) {
    throw ConfigError(file.string() +
                      ": cannot be read: no such configuration file, or no permission");
  }
  std::ostringstream text;
  text << in.rdbuf();
  addText(text.str(), file.string());
}

void ConfigLoader::addText(const std::string& yaml, const std::string& origin) {
  YAML::Node root;
  try {
    root = YAML::Load(yaml);
  } catch (const YAML::Exception& e) {
    throw ConfigError(origin + ": not valid YAML: " + e.what());
  }
  if (!root.IsDefined() || root.IsNull())
    throw ConfigError(origin + ": is empty; expected a table of keys");
  if (!root.IsMap()) throw ConfigError(origin + ": expected a table of keys at the top level");
  impl_->layers.push_back({root, origin});
}

void ConfigLoader::addOverride(const std::string& key_equals_value) {
  const auto eq = key_equals_value.find('=');
  if (eq == std::string::npos || eq == 0) {
    throw ConfigError("--set " + key_equals_value +
                      ": expected KEY=VALUE, e.g. odometry.source=rawlog");
  }
  const std::string key = key_equals_value.substr(0, eq);
  try {
    YAML::Node value = YAML::Load(key_equals_value.substr(eq + 1));
    std::istringstream parts(key);
    std::vector<std::string> path;
    for (std::string part; std::getline(parts, part, '.');) path.push_back(part);
    for (auto it = path.rbegin(); it != path.rend(); ++it) {
      YAML::Node parent(YAML::NodeType::Map);
      parent[*it] = value;
      value = parent;
    }
    impl_->layers.push_back({value, "--set"});
  } catch (const YAML::Exception& e) {
    throw ConfigError("--set " + key_equals_value + ": not a valid value: " + e.what());
  }
}

void ConfigLoader::apply(const Visit& visit) const {
  std::vector<std::string> problems;
  for (const auto& layer : impl_->layers) {
    YamlReader reader(layer.root, layer.origin, problems);
    visit(reader);
    reader.finish();
  }
  if (problems.empty()) return;
  std::string message = problems.size() == 1
                            ? ""
                            : std::to_string(problems.size()) + " problems in the configuration:";
  for (const auto& problem : problems) message += (message.empty() ? "" : "\n  ") + problem;
  throw ConfigError(message);
}

std::string dumpYaml(const ConfigLoader::Visit& visit, bool documented) {
  YamlWriter writer(documented);
  visit(writer);
  return writer.str();
}

}  // namespace dynemo
