#pragma once

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdlib>
#include <string>

namespace dynemo {

/// A finite number for which `fits` holds; `constraint` tells people which that is.
template <class Predicate>
CLI::Validator finiteNumber(const std::string& constraint, Predicate fits) {
  return CLI::Validator(
      [constraint, fits](std::string& text) -> std::string {
        char* end = nullptr;
        const double value = std::strtod(text.c_str(), &end);
        const bool number = end != text.c_str() && *end == '\0' && std::isfinite(value);
        return number && fits(value) ? "" : text + ": must be " + constraint;
      },
      "");
}

/// CLI11's own checks name the smallest and the largest double as the bounds.
inline CLI::Validator positiveNumber() {
  return finiteNumber("a number > 0", [](double value) { return value > 0.0; });
}
inline CLI::Validator nonNegativeNumber() {
  return finiteNumber("a number >= 0", [](double value) { return value >= 0.0; });
}

}  // namespace dynemo
