// Reads and writes parameter structs as YAML through their field lists (fields.h).
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "dynemo/core/fields.h"

namespace dynemo {

/// Overlays layers of YAML onto a parameter struct. Later layers win; what no layer names keeps its
/// value. All violations of all layers are collected and thrown together by apply().
class ConfigLoader {
 public:
  using Visit = std::function<void(FieldVisitor&)>;

  ConfigLoader();
  ~ConfigLoader();

  /// Adds a YAML file. Throws ConfigError when it cannot be read, is empty or is not YAML.
  void addFile(const std::filesystem::path& file);
  /// Adds YAML text; `origin` names it in messages.
  void addText(const std::string& yaml, const std::string& origin);
  /// Adds one "section.key=value" override, the value in YAML.
  void addOverride(const std::string& key_equals_value);

  /// Visits the fields with every layer in turn. Throws one ConfigError that lists, per violation,
  /// the file, the key, the value and the constraint: unknown keys, wrong types, values out of
  /// range.
  void apply(const Visit& visit) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// YAML text of all fields with their current values, in the order of the field list; with
/// `documented`, each preceded by its description and range as a comment. Numbers round-trip
/// exactly.
std::string dumpYaml(const ConfigLoader::Visit& visit, bool documented);

/// Overlays `loader`'s layers onto params.
template <class Params>
void load(const ConfigLoader& loader, Params& params) {
  loader.apply([&](FieldVisitor& v) { fields(v, params); });
}

template <class Params>
std::string toYaml(Params params, bool documented = true) {
  return dumpYaml([&](FieldVisitor& v) { fields(v, params); }, documented);
}

}  // namespace dynemo
