// How roughly the robot has been moving of late.
#pragma once

#include "dynemo/odometry/sweep_motion.h"

namespace dynemo {

/// Root mean square accelerations with exponential forgetting. A calm robot's sweeps need little
/// freedom of motion, and what freedom they have turns into noise of the pose.
class Agitation {
 public:
  /// Starts as agitated as the given accelerations.
  Agitation(double linear_m_s2, double angular_rad_s2, double memory)
      : linear2_(linear_m_s2 * linear_m_s2),
        angular2_(angular_rad_s2 * angular_rad_s2),
        memory_(memory) {}

  /// The mean velocity changed from one interval to the next, dt_s > 0 later. Displacements between
  /// sweeps tell it with much less noise than the motion within them.
  void add(const BodyTwist& before, const BodyTwist& now, double dt_s);
  double linear_m_s2() const;
  double angular_rad_s2() const;

 private:
  double linear2_, angular2_;
  double memory_;
};

}  // namespace dynemo
