#include "dynemo/pipeline/doubts.h"

namespace dynemo {
namespace {

/// A guess now and then is what the graph is there to bridge.
constexpr double kMostGuessed = 0.1;

std::string entityDoubt(const RunFacts& run) {
  const std::string detections = std::to_string(run.unknown_detections) + " entity detections ";
  if (!run.entities_described)
    return run.unknown_detections == 0
               ? ""
               : detections + "were left out: without --entities nothing says what they are of";
  if (run.entities > 0) return "";
  return run.unknown_detections > 0
             ? "none of the " + detections + "is of an entity of the entity file"
             : "no entity of the entity file was seen";
}

}  // namespace

std::vector<std::string> doubtsAbout(const RunFacts& run) {
  std::vector<std::string> doubts;
  if (run.frames == 0) return doubts;
  const bool lost =
      static_cast<double>(run.guessed_frames) > kMostGuessed * static_cast<double>(run.frames);
  if (lost)
    doubts.push_back("the robot's motion is not known in " + std::to_string(run.guessed_frames) +
                     " of " + std::to_string(run.frames) + " frames: the map is not to be trusted");
  else if (run.keyframes == 1 && run.frames > 1)
    doubts.emplace_back("the robot hardly moved: the map is what was seen from one place");
  const std::string about_entities = run.entities_mapped ? entityDoubt(run) : "";
  if (!about_entities.empty()) doubts.push_back(about_entities);
  return doubts;
}

}  // namespace dynemo
