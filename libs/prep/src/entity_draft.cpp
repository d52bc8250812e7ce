#include <algorithm>
#include <cstdio>
#include <sstream>

#include "dynemo/core/error.h"
#include "dynemo/prep/tag_survey.h"

namespace dynemo {
namespace {

/// Faster than this in the odometry frame is no object.
constexpr double kAgentSpeed_m_s = 0.25;

std::string fixed(double value, int digits) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.*f", digits, value);
  return text;
}

const char* kHead = R"(# Where the tags sit: a first draft from %s, to be edited.
#  - id, class, name: give entities ids of your own; agent = moves by itself (people, robots), object = gets carried.
#  - One entity is drafted for each tag. Where several tags sit on one thing, list them under one entity, each with its
#    pose in the entity's frame (x forward, y left, z up).
#  - size: side of the black square, without the white border. Measure it: a wrong size is a wrong distance.
#  - pose: [x, y, z, qx, qy, qz, qw] of the tag in the entity's frame; the tag's axes are x right, y down, z into the
#    tag. Here: the tag faces forward, in the origin of the entity.
#  - origin_z (optional): height of the entity's origin over the floor [m].
)";

std::string head(const std::string& origin) {
  std::string text = kHead;
  text.replace(text.find("%s"), 2, origin);
  return text;
}

/// What was seen of the tag, as a comment.
std::string evidence(const SurveyedTag& tag) {
  std::string text = "seen " + std::to_string(tag.sightings) + " times, " +
                     fixed(tag.min_edge_px, 0) + " to " + fixed(tag.max_edge_px, 0) + " px";
  if (tag.speed_m_s) text += ", speed " + fixed(*tag.speed_m_s, 2) + " m/s";
  if (tag.measured_size_m)
    text += ", size " + fixed(*tag.measured_size_m, 3) + " m by " +
            std::to_string(tag.size_points) + " LiDAR points";
  for (std::size_t i = 0; i < std::min<std::size_t>(2, tag.neighbours.size()); ++i) {
    const auto& n = tag.neighbours[i];
    text += "; " + std::to_string(n.times) + " times together with tag " + std::to_string(n.id) +
            ", " + fixed(n.distance_m, 2) + " m away";
  }
  return text;
}

}  // namespace

std::string entityFileDraft(const TagSurvey& survey, const TagSurveyParams& params,
                            int min_sightings, const std::string& origin) {
  const auto common_size_m = survey.commonSize_m();
  if (!common_size_m && !survey.tags().empty())
    throw ConfigError(
        "the size of the tags is not known: give --size (no LiDAR points on calibrated images of "
        "tags to measure it)");
  std::ostringstream out;
  out << head(origin) << "tag_family: " << params.family << "\nentities:";
  bool any = false;
  std::string rare;
  for (const SurveyedTag& tag : survey.tags()) {
    if (tag.sightings < min_sightings) {
      rare += (rare.empty() ? "" : ", ") + std::to_string(tag.id);
      continue;
    }
    const bool agent = tag.speed_m_s.value_or(0.0) > kAgentSpeed_m_s;
    const double size_m =
        params.size_m ? *params.size_m : tag.measured_size_m.value_or(*common_size_m);
    out << "\n  - id: " << tag.id << "  # " << evidence(tag)
        << "\n    class: " << (agent ? "agent" : "object") << "\n    tags:\n      - {id: " << tag.id
        << ", size: " << fixed(size_m, 3) << ", pose: [0, 0, 0, -0.5, -0.5, 0.5, 0.5]}";
    any = true;
  }
  out << (any ? "\n" : " []\n");
  if (!rare.empty())
    out << "# Left out, seen less than " << min_sightings << " times (perhaps false): " << rare
        << '\n';
  return out.str();
}

}  // namespace dynemo
