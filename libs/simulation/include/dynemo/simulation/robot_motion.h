// Where the robot truly is at any time: smooth, and a pure function of the world and its seed.
#pragma once

#include <array>
#include <vector>

#include "dynemo/core/se3.h"
#include "dynemo/simulation/world.h"

namespace dynemo::simulation {

/// A piecewise-linear curve, constant before its first and after its last knot, rounded by two
/// moving averages: its second derivative is continuous.
class SmoothCurve {
 public:
  static constexpr int kChannels = 4;
  using Value = Eigen::Matrix<double, kChannels, 1>;
  struct Knot {
    double t_s;
    Value value;
  };

  SmoothCurve() = default;
  /// Knots by time; `half_width_s` is how far the rounding reaches to each side.
  SmoothCurve(std::vector<Knot> knots, double half_width_s);

  Value at(double t_s) const;

 private:
  Value linearAt(double t_s, std::size_t segment) const;
  std::size_t segmentAt(double t_s) const;

  std::vector<Knot> knots_;
  double half_width_s_ = 0.1;
};

/// A sum of sine waves with random phases.
struct Waves {
  struct Wave {
    double amplitude, frequency, phase;
  };
  std::vector<Wave> waves;
  double at(double x) const;
};

class RobotMotion {
 public:
  RobotMotion(const Robot& robot, int seed);

  /// T_world_base; before the start and after the end of the route the robot stands still.
  Pose3 at(double t_s) const;
  /// Point on the floor under the base.
  Vector3 floorPoint(double t_s) const;
  /// Distance driven [m].
  double distance(double t_s) const;
  /// When the last lap ends.
  double end_s() const { return end_s_; }
  /// When the first lap ends.
  double lap_s() const { return lap_s_; }

 private:
  struct Shake {
    Waves by_distance, by_time;
  };

  Robot robot_;
  SmoothCurve position_;   ///< x y z of the floor, distance driven
  SmoothCurve direction_;  ///< yaw, pitch of the slope
  Shake height_, yaw_, pitch_, roll_;
  double end_s_ = 0.0, lap_s_ = 0.0;
};

}  // namespace dynemo::simulation
