// Failures. Configuration, input and format errors throw one of these and are caught in main only;
// expected outcomes (not converged, rejected) are values.
#pragma once

#include <stdexcept>
#include <string>
#include <tl/expected.hpp>

namespace dynemo {

/// A wrong command line or configuration: names file, key, value and violated constraint. Exit
/// status 2.
class ConfigError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Input that cannot be used, or output that cannot be written. Exit status 3.
class DataError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A value, or the reason why there is none.
template <class T, class E>
using Expected = tl::expected<T, E>;
using tl::make_unexpected;

/// Process exit statuses of every program.
enum class ExitStatus : int { kOk = 0, kUsage = 2, kData = 3, kInternal = 4 };

}  // namespace dynemo
