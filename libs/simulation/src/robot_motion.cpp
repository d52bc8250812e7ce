#include "dynemo/simulation/robot_motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "random.h"

namespace dynemo::simulation {
namespace {

constexpr double kPositionRounding_s = 0.4, kDirectionRounding_s = 0.3;
/// Sharper turns are made on the spot; the others while driving on.
constexpr double kTurnOnTheSpot_rad = 0.6;
constexpr double kTurnWhileDriving_s = 0.8;

double wrapped(double angle_rad) { return std::remainder(angle_rad, 2.0 * std::numbers::pi); }

Waves drawWaves(Random& random, double amplitude, double low_frequency, double high_frequency) {
  constexpr int kWaves = 4;
  Waves sum;
  for (int i = 0; i < kWaves; ++i) {
    sum.waves.push_back({random.uniform(0.6, 1.0) * amplitude / kWaves,
                         random.uniform(low_frequency, high_frequency),
                         random.uniform(0.0, 2.0 * std::numbers::pi)});
  }
  return sum;
}

/// The stretches of all laps with their times.
class Timetable {
 public:
  explicit Timetable(const Robot& robot) : robot_(robot) {}

  void drive() {
    position_.push_back(knot(robot_.route.front().at));
    direction_.push_back({0.0, heading(0)});
    for (int lap = 0; lap < robot_.laps; ++lap) {
      for (std::size_t i = lap == 0 ? 1 : 0; i < robot_.route.size(); ++i) goTo(robot_.route[i]);
      if (lap == 0) lap_s_ = t_s_;
    }
  }

  std::vector<SmoothCurve::Knot> position_, direction_;
  double t_s_ = 0.0, s_m_ = 0.0, lap_s_ = 0.0;

 private:
  SmoothCurve::Knot knot(const Vector3& p) const { return {t_s_, {p.x(), p.y(), p.z(), s_m_}}; }

  SmoothCurve::Value heading(std::size_t from) const {
    for (std::size_t i = from; i + 1 < robot_.route.size(); ++i) {
      const Vector3 step = robot_.route[i + 1].at - robot_.route[i].at;
      if (step.head<2>().norm() > 1e-6) return headingOf(step, 0.0);
    }
    return SmoothCurve::Value::Zero();
  }

  static SmoothCurve::Value headingOf(const Vector3& step, double near_yaw_rad) {
    const double yaw_rad = std::atan2(step.y(), step.x());
    return {near_yaw_rad + wrapped(yaw_rad - near_yaw_rad),
            -std::atan2(step.z(), step.head<2>().norm()), 0, 0};
  }

  void goTo(const RoutePoint& point) {
    const Vector3 from = position_.back().value.head<3>();
    const Vector3 step = point.at - from;
    if (step.head<2>().norm() > 1e-6) {
      turn(headingOf(step, direction_.back().value[0]));
      t_s_ += step.norm() / robot_.speed_m_s;
      s_m_ += step.norm();
      position_.push_back(knot(point.at));
    }
    if (point.wait_s > 0.0) stand(point.wait_s);
  }

  void turn(const SmoothCurve::Value& target) {
    const SmoothCurve::Value now = direction_.back().value;
    const double angle_rad = std::abs(target[0] - now[0]);
    if (angle_rad > kTurnOnTheSpot_rad) {
      direction_.push_back({t_s_, now});
      stand(angle_rad / robot_.turn_rate_rad_s + kDirectionRounding_s);
      direction_.push_back({t_s_, target});
    } else {
      const double begin_s = std::max(t_s_ - 0.5 * kTurnWhileDriving_s, direction_.back().t_s);
      direction_.push_back({begin_s, now});
      direction_.push_back({begin_s + kTurnWhileDriving_s, target});
    }
  }

  void stand(double duration_s) {
    t_s_ += duration_s;
    SmoothCurve::Knot same = position_.back();
    same.t_s = t_s_;
    position_.push_back(same);
  }

  const Robot& robot_;
};

}  // namespace

SmoothCurve::SmoothCurve(std::vector<Knot> knots, double half_width_s)
    : knots_(std::move(knots)), half_width_s_(half_width_s) {}

/// Segment k lies before knot k; segment 0 and the last are constant.
std::size_t SmoothCurve::segmentAt(double t_s) const {
  return static_cast<std::size_t>(
      std::upper_bound(knots_.begin(), knots_.end(), t_s,
                       [](double t, const Knot& k) { return t < k.t_s; }) -
      knots_.begin());
}

SmoothCurve::Value SmoothCurve::linearAt(double t_s, std::size_t segment) const {
  if (segment == 0) return knots_.front().value;
  if (segment == knots_.size()) return knots_.back().value;
  const Knot &a = knots_[segment - 1], &b = knots_[segment];
  return a.value + (t_s - a.t_s) / (b.t_s - a.t_s) * (b.value - a.value);
}

SmoothCurve::Value SmoothCurve::at(double t_s) const {
  // ∫ p(t + τ) (h − |τ|)/h² dτ over |τ| ≤ h. Between knots and τ = 0 the integrand is a parabola,
  // for which the two-point Gauss rule is exact.
  const double h = half_width_s_, end = t_s + h;
  const double root = 0.5 / std::sqrt(3.0);
  Value sum = Value::Zero();
  double begin = t_s - h;
  std::size_t segment = segmentAt(begin);
  while (begin < end) {
    double stop = segment < knots_.size() ? std::min(end, knots_[segment].t_s) : end;
    if (begin < t_s) stop = std::min(stop, t_s);
    for (const double at : {0.5 - root, 0.5 + root}) {
      const double u = begin + at * (stop - begin);
      const double weight = (h - std::abs(u - t_s)) / (h * h);
      sum += 0.5 * (stop - begin) * weight * linearAt(u, segment);
    }
    // Knots at the same time are a jump; nothing lies between them.
    while (segment < knots_.size() && stop >= knots_[segment].t_s) ++segment;
    begin = stop;
  }
  return sum;
}

double Waves::at(double x) const {
  double sum = 0.0;
  for (const Wave& w : waves)
    sum += w.amplitude * std::sin(2.0 * std::numbers::pi * w.frequency * x + w.phase);
  return sum;
}

RobotMotion::RobotMotion(const Robot& robot, int seed) : robot_(robot) {
  Timetable times(robot);
  times.drive();
  end_s_ = times.t_s_;
  lap_s_ = times.lap_s_;
  position_ = SmoothCurve(std::move(times.position_), kPositionRounding_s);
  direction_ = SmoothCurve(std::move(times.direction_), kDirectionRounding_s);

  constexpr double kDegree = std::numbers::pi / 180.0;
  Random random(seed, Purpose::kMotion);
  if (robot.carrier == Carrier::kWheels) {
    height_.by_distance = drawWaves(random, 0.002, 0.3, 1.5);
    pitch_.by_distance = drawWaves(random, 0.7 * kDegree, 0.2, 1.0);
    roll_.by_distance = drawWaves(random, 0.7 * kDegree, 0.2, 1.0);
  } else {
    // About 1.8 steps per metre; slower swaying and looking about also while standing.
    height_ = {drawWaves(random, 0.03, 1.7, 1.9), drawWaves(random, 0.02, 0.1, 0.4)};
    yaw_ = {drawWaves(random, 2.0 * kDegree, 0.8, 1.0),
            drawWaves(random, 30.0 * kDegree, 0.05, 0.3)};
    pitch_ = {drawWaves(random, 2.0 * kDegree, 1.7, 1.9),
              drawWaves(random, 5.0 * kDegree, 0.1, 0.6)};
    roll_ = {drawWaves(random, 2.0 * kDegree, 0.8, 1.0),
             drawWaves(random, 4.0 * kDegree, 0.1, 0.6)};
  }
}

Pose3 RobotMotion::at(double t_s) const {
  const SmoothCurve::Value p = position_.at(t_s), d = direction_.at(t_s);
  const auto shaken = [&](const Shake& shake) {
    return shake.by_distance.at(p[3]) + shake.by_time.at(t_s);
  };
  const bool wheels = robot_.carrier == Carrier::kWheels;
  return Pose3::fromYawPitchRoll(p[0], p[1], p[2] + robot_.base_height_m + shaken(height_),
                                 d[0] + shaken(yaw_), (wheels ? d[1] : 0.0) + shaken(pitch_),
                                 shaken(roll_));
}

Vector3 RobotMotion::floorPoint(double t_s) const { return position_.at(t_s).head<3>(); }

double RobotMotion::distance(double t_s) const { return position_.at(t_s)[3]; }

}  // namespace dynemo::simulation
