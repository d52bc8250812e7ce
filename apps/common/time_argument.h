#pragma once

#include <cmath>
#include <stdexcept>
#include <string>

#include "dynemo/core/error.h"
#include "dynemo/core/time.h"

namespace dynemo {

constexpr const char* kTimeHelp = "UNIX seconds, or +S for S seconds after the run's first frame";

/// Reads a time as kTimeHelp says; throws ConfigError naming the option otherwise.
inline Stamp parseTime(const std::string& text, Stamp begin, const std::string& option) {
  try {
    if (!text.starts_with('+')) return Stamp::parse(text);
    return {begin.ns + Stamp::parse(text.substr(1)).ns};
  } catch (const std::invalid_argument&) {
    throw ConfigError(option + " " + text + ": must be " + kTimeHelp);
  }
}

}  // namespace dynemo
