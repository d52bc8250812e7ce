#pragma once

#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <string>

#include "dynemo/core/error.h"
#include "dynemo/core/time.h"

namespace dynemo {

constexpr const char* kTimeHelp = "UNIX seconds, or +S for S seconds after the run's first frame";

/// The times between a run's first and last frame.
struct RunSpan {
  Stamp begin, end;
};

namespace detail {

inline std::string spanText(const RunSpan& run) {
  char relative[64];
  std::snprintf(relative, sizeof(relative), " (+0 to +%.3f)", secondsBetween(run.begin, run.end));
  return run.begin.text() + " to " + run.end.text() + relative;
}

}  // namespace detail

/// Reads a time as kTimeHelp says. What was before and what will be after the run may be asked for,
/// but a time further away than any such question means the other form. Throws ConfigError naming
/// the option, and the run's span when the time lies far outside of it.
inline Stamp parseTime(const std::string& text, const RunSpan& run, const std::string& option) {
  constexpr double kFarAway_s = 30.0 * 86400.0;
  const bool relative = text.starts_with('+');
  Stamp parsed;
  try {
    parsed = Stamp::parse(relative ? text.substr(1) : text);
  } catch (const std::invalid_argument&) {
    throw ConfigError(option + " " + text + ": must be " + kTimeHelp);
  }
  const double after_begin_s = relative ? parsed.seconds() : secondsBetween(run.begin, parsed);
  const double after_end_s = after_begin_s - secondsBetween(run.begin, run.end);
  if (after_begin_s < -kFarAway_s || after_end_s > kFarAway_s)
    throw ConfigError(option + " " + text + ": is far from the run, which lasts from " +
                      detail::spanText(run) + "; must be " + kTimeHelp);
  return relative ? Stamp{run.begin.ns + parsed.ns} : parsed;
}

}  // namespace dynemo
