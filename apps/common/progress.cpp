#include "progress.h"

#include <mrpt/system/progress.h>
#include <unistd.h>

#include <cstdio>
#include <iostream>

namespace dynemo {
namespace {
constexpr double kTerminalInterval_s = 0.1;
constexpr double kLineInterval_s = 10.0;
}  // namespace

Progress::Progress(bool enabled) : enabled_(enabled), terminal_(isatty(STDERR_FILENO) != 0) {}

Progress::~Progress() { clear(); }

double Progress::elapsed_s() const {
  return std::chrono::duration<double>(Clock::now() - start_).count();
}

std::string Progress::text(double fraction, double dataset_s) const {
  const double wall_s = elapsed_s();
  const double factor = wall_s > 0 ? dataset_s / wall_s : 0.0;
  char numbers[128];
  std::snprintf(numbers, sizeof(numbers), "%3.0f %%  %.1f s of data  %.1fx real time",
                100.0 * fraction, dataset_s, factor);
  std::string text = numbers;
  if (fraction <= 0) return text;
  std::snprintf(numbers, sizeof(numbers), "  ETA %.0f s", wall_s * (1.0 - fraction) / fraction);
  return text + numbers;
}

void Progress::update(double fraction, double dataset_s) {
  if (!enabled_) return;
  const auto now = Clock::now();
  const double interval_s = terminal_ ? kTerminalInterval_s : kLineInterval_s;
  if (std::chrono::duration<double>(now - last_).count() < interval_s) return;
  last_ = now;
  if (terminal_) {
    std::cerr << '\r' << mrpt::system::progress(fraction, 30) << ' ' << text(fraction, dataset_s)
              << "\033[K" << std::flush;
    drawn_ = true;
  } else {
    std::cerr << text(fraction, dataset_s) << '\n';
  }
}

void Progress::clear() {
  if (drawn_) std::cerr << "\r\033[K" << std::flush;
  drawn_ = false;
}

}  // namespace dynemo
