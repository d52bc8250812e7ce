// One list of fields per parameter struct, which drives loading, dumping, range checks and
// documentation.
//
//   struct PolicyParams { double translation_m = 1.0; double rotation_rad = 0.5; Mode mode =
//   Mode::kDynamic; }; void fields(FieldVisitor& v, PolicyParams& p) {
//     v.number("translation_m", p.translation_m, "Robot motion that makes a keyframe",
//     Range::positive()); v.angle("rotation_deg", p.rotation_rad, "…");            // radians in
//     the struct, degrees in YAML v.choice("mode", p.mode, {"baseline", "dynamic"}, "…");    //
//     enumerators in the order of the names
//   }
//   v.section("keyframes", params.keyframes, "…");               // nests; finds fields() by its
//   argument
//
// Defaults are the in-class initialisers of the struct, nowhere else.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace dynemo {

/// Closed interval of allowed values, in the unit of the key (degrees for angles).
struct Range {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool min_excluded = false;

  static Range any() { return {}; }
  static Range positive() { return {0.0, std::numeric_limits<double>::infinity(), true}; }
  static Range nonNegative() { return {0.0, std::numeric_limits<double>::infinity(), false}; }
  static Range between(double lo, double hi) { return {lo, hi, false}; }
  bool contains(double v) const { return (min_excluded ? v > min : v >= min) && v <= max; }
  /// "> 0", "in [0, 1]", …
  std::string text() const;
};

class FieldVisitor {
 public:
  virtual ~FieldVisitor() = default;

  virtual void number(const char* key, double& value, const char* doc, Range range = {}) = 0;
  virtual void integer(const char* key, int& value, const char* doc, Range range = {}) = 0;
  virtual void flag(const char* key, bool& value, const char* doc) = 0;
  virtual void text(const char* key, std::string& value, const char* doc) = 0;
  virtual void numbers(const char* key, std::vector<double>& value, const char* doc) = 0;
  virtual void texts(const char* key, std::vector<std::string>& value, const char* doc) = 0;
  /// Free-form table of rows, e.g. extrinsics by sensor label.
  virtual void table(const char* key, std::map<std::string, std::vector<double>>& value,
                     const char* doc) = 0;
  /// `null` in YAML means "off".
  virtual void optionalNumber(const char* key, std::optional<double>& value, const char* doc,
                              Range range = {}) = 0;

  /// Radians in the struct, degrees in the file; the key ends in _deg and the range is in degrees.
  void angle(const char* key_deg, double& value_rad, const char* doc, Range range_deg = {});

  template <class Enum>
  void choice(const char* key, Enum& value, std::initializer_list<const char*> names,
              const char* doc) {
    int index = static_cast<int>(value);
    choiceIndex(key, index, std::vector<std::string>(names.begin(), names.end()), doc);
    value = static_cast<Enum>(index);
  }

  template <class Params>
  void section(const char* key, Params& params, const char* doc) {
    if (!enter(key, doc)) return;
    fields(*this, params);
    leave();
  }

 protected:
  virtual void choiceIndex(const char* key, int& index, const std::vector<std::string>& names,
                           const char* doc) = 0;
  /// False skips the section.
  virtual bool enter(const char* key, const char* doc) = 0;
  virtual void leave() = 0;
};

}  // namespace dynemo
