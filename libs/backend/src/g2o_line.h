#pragma once

#include <charconv>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>

#include "dynemo/core/error.h"
#include "dynemo/core/se3.h"

namespace dynemo::backend {

/// One record, taken apart token by token; every complaint names file and line.
class Line {
 public:
  /// MRPT annotates its vertices behind a bar.
  Line(std::string_view text, const std::string& name, int number)
      : rest_(text.substr(0, text.find(" | "))), name_(name), number_(number) {}

  [[noreturn]] void fail(const std::string& what) const {
    throw DataError(name_ + ": line " + std::to_string(number_) + ": " + what);
  }
  std::string_view word() {
    const auto first = rest_.find_first_not_of(" \t\r");
    if (first == std::string_view::npos) return rest_ = {};
    const auto last = std::min(rest_.find_first_of(" \t\r", first), rest_.size());
    const std::string_view token = rest_.substr(first, last - first);
    rest_.remove_prefix(last);
    return token;
  }
  std::uint64_t id() { return parse<std::uint64_t>("a vertex id"); }
  double number() {
    const double value = parse<double>("a number");
    if (!std::isfinite(value)) fail("a value is not finite");
    return value;
  }
  Pose3 pose() {
    double v[7];
    for (double& x : v) x = number();
    const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
    if (!(q.norm() > 1e-6 && q.norm() < 1e6)) fail("the quaternion is not of unit length");
    return {q, Vector3(v[0], v[1], v[2])};
  }
  /// x y z roll pitch yaw.
  Pose3 poseOfAngles() {
    double v[6];
    for (double& x : v) x = number();
    return Pose3::fromYawPitchRoll(v[0], v[1], v[2], v[5], v[4], v[3]);
  }
  /// 21 values of the upper triangle, row by row.
  Matrix6 symmetricMatrix() {
    Matrix6 m;
    for (int r = 0; r < 6; ++r)
      for (int c = r; c < 6; ++c) m(r, c) = m(c, r) = number();
    return m;
  }
  bool atEnd() const { return rest_.find_first_not_of(" \t\r") == std::string_view::npos; }
  void end() {
    if (!atEnd()) fail("more values than expected");
  }

 private:
  template <class T>
  T parse(const char* expected) {
    std::string_view token = word();
    if (token.empty()) fail(std::string("expected ") + expected + ", found the end of the line");
    if (token.front() == '+') token.remove_prefix(1);
    T value{};
    const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), value);
    if (error != std::errc() || end != token.data() + token.size()) {
      fail(std::string("expected ") + expected + ", found '" + std::string(token.substr(0, 40)) +
           "'");
    }
    return value;
  }

  std::string_view rest_;
  const std::string& name_;
  int number_;
};

}  // namespace dynemo::backend
