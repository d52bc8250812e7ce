#pragma once

#include <chrono>
#include <string>

namespace dynemo {

/// A bar that redraws itself on a terminal, a plain line now and then elsewhere; on stderr.
class Progress {
 public:
  explicit Progress(bool enabled);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Share done so far, 0 … 1, and the seconds of the dataset that it covers.
  void update(double fraction, double dataset_s);
  /// Clears the bar so that a message can be printed.
  void clear();
  double elapsed_s() const;

 private:
  using Clock = std::chrono::steady_clock;
  std::string text(double fraction, double dataset_s) const;

  bool enabled_, terminal_;
  bool drawn_ = false;
  Clock::time_point start_ = Clock::now(), last_ = start_;
};

}  // namespace dynemo
