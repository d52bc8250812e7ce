#pragma once

#include <random>

#include "dynemo/core/noise.h"
#include "dynemo/core/se3.h"

namespace dynemo::test {

/// The same numbers with every standard library.
class RandomValues {
 public:
  explicit RandomValues(std::uint64_t seed) : rng_(seed) {}
  double uniform(double lo, double hi) {
    return lo + (hi - lo) * (static_cast<double>(rng_() >> 11) * 0x1.0p-53);
  }
  Vector3 vector(double half_side) {
    return {uniform(-half_side, half_side), uniform(-half_side, half_side),
            uniform(-half_side, half_side)};
  }
  Vector3 direction() {
    Vector3 v = vector(1.0);
    while (v.norm() < 0.1 || v.norm() > 1.0) v = vector(1.0);
    return v.normalized();
  }
  /// Any rotation up to `max_angle_rad`, translations up to 5 m per axis.
  Pose3 pose(double max_angle_rad) {
    return {expSO3(uniform(0, max_angle_rad) * direction()), vector(5.0)};
  }
  Vector6 tangent(double scale) {
    Vector6 d;
    d << vector(scale), vector(scale);
    return d;
  }
  MatrixX spd(int n) {
    MatrixX A(n, n);
    for (int i = 0; i < n * n; ++i) A.data()[i] = uniform(-1, 1);
    return A * A.transpose() + 0.3 * MatrixX::Identity(n, n);
  }

 private:
  std::mt19937_64 rng_;
};

}  // namespace dynemo::test
