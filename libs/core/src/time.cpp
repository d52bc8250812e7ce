#include "dynemo/core/time.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <stdexcept>

namespace dynemo {
namespace {
constexpr std::int64_t kNsPerSecond = 1'000'000'000;
}

Stamp Stamp::fromSeconds(double seconds) {
  if (!(std::abs(seconds) < 9.0e9)) throw std::invalid_argument("time stamp out of range");
  const double whole = std::floor(seconds);
  return {static_cast<std::int64_t>(whole) * kNsPerSecond + std::llround((seconds - whole) * 1e9)};
}

Stamp Stamp::parse(const std::string& text) {
  const auto fail = [&] {
    throw std::invalid_argument("'" + text + "' is not a time stamp in seconds");
  };
  std::size_t i = 0;
  const bool negative = !text.empty() && text[0] == '-';
  if (negative || (!text.empty() && text[0] == '+')) ++i;
  if (text.find_first_of("eE", i) != std::string::npos) {
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    if (end == text.c_str() || *end != '\0' || !std::isfinite(value)) fail();
    return fromSeconds(value);
  }
  std::int64_t whole = 0, fraction = 0;
  int digits = 0, fraction_digits = 0;
  for (; i < text.size() && text[i] >= '0' && text[i] <= '9'; ++i, ++digits) {
    if (whole > 9'000'000'000) fail();
    whole = whole * 10 + (text[i] - '0');
  }
  if (i < text.size() && text[i] == '.') {
    for (++i; i < text.size() && text[i] >= '0' && text[i] <= '9'; ++i, ++digits) {
      if (fraction_digits == 9) continue;
      fraction = fraction * 10 + (text[i] - '0');
      ++fraction_digits;
    }
  }
  if (digits == 0 || i != text.size() || whole > 9'000'000'000) fail();
  for (; fraction_digits < 9; ++fraction_digits) fraction *= 10;
  const std::int64_t ns = whole * kNsPerSecond + fraction;
  return {negative ? -ns : ns};
}

std::string Stamp::text() const {
  // Sign and magnitude, as parse() reads it.
  const std::uint64_t magnitude =
      ns < 0 ? 0 - static_cast<std::uint64_t>(ns) : static_cast<std::uint64_t>(ns);
  char buffer[48];
  std::snprintf(buffer, sizeof(buffer), "%s%llu.%09llu", ns < 0 ? "-" : "",
                static_cast<unsigned long long>(magnitude / kNsPerSecond),
                static_cast<unsigned long long>(magnitude % kNsPerSecond));
  return buffer;
}

}  // namespace dynemo
