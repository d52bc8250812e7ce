#pragma once

#include <chrono>
#include <string>

#include "dynemo/ingest/frame_source.h"

namespace dynemo {

/// A bar that redraws itself on a terminal, a plain line now and then elsewhere; on stderr.
class Progress {
 public:
  explicit Progress(bool enabled);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void update(const IngestProgress& progress);
  /// Clears the bar so that a message can be printed.
  void clear();
  double elapsed_s() const;

 private:
  using Clock = std::chrono::steady_clock;
  std::string text(const IngestProgress& progress) const;

  bool enabled_, terminal_;
  bool drawn_ = false;
  Clock::time_point start_ = Clock::now(), last_ = start_;
};

}  // namespace dynemo
