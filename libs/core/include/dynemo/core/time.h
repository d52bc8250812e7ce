// Time stamps of observations: integer nanoseconds since the UNIX epoch (UTC), exact and totally
// ordered.
#pragma once

#include <cstdint>
#include <string>

namespace dynemo {

struct Stamp {
  std::int64_t ns = 0;

  static Stamp fromSeconds(double seconds);
  /// Parses decimal seconds ("1700000030.123456789") without going through a double.
  /// Throws std::invalid_argument when the text is not a decimal number.
  static Stamp parse(const std::string& decimal_seconds);

  double seconds() const { return static_cast<double>(ns) * 1e-9; }
  /// Decimal seconds with nine fractional digits.
  std::string text() const;

  friend auto operator<=>(const Stamp&, const Stamp&) = default;
};

/// a − b [s]; exact subtraction before the conversion to double.
inline double secondsBetween(Stamp b, Stamp a) { return static_cast<double>(a.ns - b.ns) * 1e-9; }

}  // namespace dynemo
