#include "dynemo/odometry/agitation.h"

#include <cmath>

namespace dynemo {

void Agitation::add(const BodyTwist& before, const BodyTwist& now, double dt_s) {
  const Vector6 change = (now.vector() - before.vector()) / dt_s;
  linear2_ = memory_ * linear2_ + (1.0 - memory_) * change.head<3>().squaredNorm();
  angular2_ = memory_ * angular2_ + (1.0 - memory_) * change.tail<3>().squaredNorm();
}

double Agitation::linear_m_s2() const { return std::sqrt(linear2_); }
double Agitation::angular_rad_s2() const { return std::sqrt(angular2_); }

}  // namespace dynemo
