#pragma once

#include <array>
#include <chrono>
#include <string>

namespace dynemo {

/// Stages of one frame, in the order of the data flow.
enum class Stage {
  kIngest,
  kOdometry,
  kDetection,
  kKeyframe,
  kFragments,
  kPlanes,
  kMapping,
  kLoops,
  kOptimization,
  kCount
};

constexpr std::array<const char*, static_cast<std::size_t>(Stage::kCount)> kStageNames = {
    "ingest", "odometry", "detection", "keyframe",    "fragments",
    "planes", "mapping",  "loops",     "optimization"};

/// Wall time of each stage of one frame [ms].
struct FrameTiming {
  std::array<double, static_cast<std::size_t>(Stage::kCount)> ms{};
  double& operator[](Stage stage) { return ms[static_cast<std::size_t>(stage)]; }
  double total() const {
    double sum = 0;
    for (const double t : ms) sum += t;
    return sum;
  }
};

/// Adds the life time of the object to one stage.
class ScopedStage {
 public:
  ScopedStage(FrameTiming& timing, Stage stage) : out_(timing[stage]) {}
  ~ScopedStage() {
    out_ += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start_)
                .count();
  }
  ScopedStage(const ScopedStage&) = delete;
  ScopedStage& operator=(const ScopedStage&) = delete;

 private:
  double& out_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace dynemo
