#pragma once

#include <chrono>
#include <ctime>

namespace dynemo::backend {

/// As a clock on the wall shows it [ms].
inline double wallTime_ms() {
  return std::chrono::duration<double, std::milli>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

/// Of the processor, for the calling thread [ms].
inline double threadTime_ms() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

/// Adds the time of its scope to a counter [ms].
template <double (*now_ms)()>
class BasicTimer {
 public:
  explicit BasicTimer(double& total_ms) : total_ms_(total_ms) {}
  ~BasicTimer() { total_ms_ += now_ms() - start_ms_; }
  BasicTimer(const BasicTimer&) = delete;
  BasicTimer& operator=(const BasicTimer&) = delete;

 private:
  double& total_ms_;
  double start_ms_ = now_ms();
};

using WallTimer = BasicTimer<wallTime_ms>;
using PhaseTimer = BasicTimer<threadTime_ms>;

}  // namespace dynemo::backend
