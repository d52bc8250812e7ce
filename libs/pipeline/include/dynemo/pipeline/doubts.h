// Why a finished run should not be trusted as a whole: what counted warnings about single frames
// do not tell by themselves.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace dynemo {

struct RunFacts {
  std::uint64_t frames = 0;
  /// Frames whose motion is a guess (RobotTracker::guessedFrames).
  std::uint64_t guessed_frames = 0;
  std::uint64_t keyframes = 0;  ///< those that left the graph included
  /// Whether the configuration maps entities at all, and whether an entity file describes any.
  bool entities_mapped = true, entities_described = false;
  std::uint64_t entities = 0;
  /// Detections left out because nothing says what their entity is.
  std::uint64_t unknown_detections = 0;
};

/// One sentence for each reason; empty for a run that is as it should be.
std::vector<std::string> doubtsAbout(const RunFacts& run);

}  // namespace dynemo
