#include "dynemo/perception/tag_family.h"

#include <apriltag/apriltag.h>
#include <apriltag/tag16h5.h>
#include <apriltag/tag25h9.h>
#include <apriltag/tag36h11.h>
#include <apriltag/tagCircle21h7.h>
#include <apriltag/tagCircle49h12.h>
#include <apriltag/tagStandard41h12.h>
#include <apriltag/tagStandard52h13.h>

#include <map>

#include "dynemo/core/error.h"

namespace dynemo {
namespace {

struct Factory {
  apriltag_family_t* (*create)();
  void (*destroy)(apriltag_family_t*);
};

const std::map<std::string, Factory>& factories() {
  static const std::map<std::string, Factory> table{
      {"tag16h5", {tag16h5_create, tag16h5_destroy}},
      {"tag25h9", {tag25h9_create, tag25h9_destroy}},
      {"tag36h11", {tag36h11_create, tag36h11_destroy}},
      {"tagCircle21h7", {tagCircle21h7_create, tagCircle21h7_destroy}},
      {"tagCircle49h12", {tagCircle49h12_create, tagCircle49h12_destroy}},
      {"tagStandard41h12", {tagStandard41h12_create, tagStandard41h12_destroy}},
      {"tagStandard52h13", {tagStandard52h13_create, tagStandard52h13_destroy}}};
  return table;
}

}  // namespace

std::vector<std::string> tagFamilyNames() {
  std::vector<std::string> names;
  for (const auto& [name, factory] : factories()) names.push_back(name);
  return names;
}

TagFamily makeTagFamily(const std::string& name) {
  const auto it = factories().find(name);
  if (it != factories().end()) return TagFamily(it->second.create(), it->second.destroy);
  std::string known;
  for (const std::string& other : tagFamilyNames()) known += (known.empty() ? "" : ", ") + other;
  throw ConfigError("unknown tag family '" + name + "'; known: " + known);
}

int tagFamilySize(const apriltag_family& family) { return static_cast<int>(family.ncodes); }

}  // namespace dynemo
