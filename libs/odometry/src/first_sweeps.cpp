#include "first_sweeps.h"

#include <algorithm>
#include <array>

namespace dynemo {
namespace {

/// Numbers of sweeps at which the map is built again: the more, the better accelerations average
/// out.
constexpr std::array<std::size_t, 3> kRefineAt{2, 5, 10};
constexpr int kRounds = 3;

double secondsBetweenMiddles(const MappedSweep& a, const MappedSweep& b) {
  return secondsBetween(a.stamp, b.stamp) + b.middle_s - a.middle_s;
}

void addToMotion(SweepMotion& motion, const Vector6& twist, const Vector6& acceleration) {
  motion.twist = BodyTwist::fromVector(motion.twist.vector() + twist);
  motion.acceleration = BodyTwist::fromVector(motion.acceleration.vector() + acceleration);
}

/// Adds the mean disagreement with the displacements (trapezoid rule) to all motions.
void correctCommonError(std::vector<MappedSweep>& sweeps) {
  Vector6 twist = Vector6::Zero(), acceleration = Vector6::Zero();
  for (std::size_t k = 1; k < sweeps.size(); ++k) {
    const MappedSweep &a = sweeps[k - 1], &b = sweeps[k];
    const double dt_s = secondsBetweenMiddles(a, b);
    const Vector6 a_twist = a.motion.twist.vector(), b_twist = b.motion.twist.vector();
    twist += twistOf(a.T_odom_middle.inverse() * b.T_odom_middle, dt_s).vector() -
             0.5 * (a_twist + b_twist);
    acceleration += (b_twist - a_twist) / dt_s -
                    0.5 * (a.motion.acceleration.vector() + b.motion.acceleration.vector());
  }
  const auto pairs = static_cast<double>(sweeps.size() - 1);
  for (MappedSweep& sweep : sweeps) addToMotion(sweep.motion, twist / pairs, acceleration / pairs);
}

Pose3 baseAtStamp(const MappedSweep& sweep) {
  return sweep.T_odom_middle * sweep.motion.at(-sweep.middle_s);
}

/// Moves all poses so that the base at the first stamp is at T_odom_base.
void fixOrigin(const Pose3& T_odom_base, std::vector<MappedSweep>& sweeps) {
  const Pose3 T_new_old = T_odom_base * baseAtStamp(sweeps.front()).inverse();
  for (MappedSweep& sweep : sweeps)
    sweep.T_odom_middle = (T_new_old * sweep.T_odom_middle).normalized();
}

}  // namespace

void insertSweep(const MappedSweep& sweep, VoxelHashMap& map) {
  const SurfacePoints& surface = sweep.surface;
  const PointCarrier carrier(sweep.motion);
  const Eigen::Matrix3f R = sweep.T_odom_middle.R.cast<float>();
  map.beginSweep();
  for (std::size_t i = 0; i < surface.size(); ++i) {
    Eigen::Vector3f p = surface.points[i];
    if (surface.timed()) p = carrier.toReference(surface.time_s[i], p);
    const Eigen::Vector3f p_odom = (sweep.T_odom_middle * p.cast<double>()).cast<float>();
    if (i < surface.onSurfaces())
      map.insert(p_odom, R * surface.normals[i]);
    else
      map.insertFromLine(p_odom, R * surface.normals[i],
                         surface.line_elevation_rad[i - surface.onSurfaces()]);
  }
}

bool FirstSweeps::add(MappedSweep sweep, VoxelHashMap& map) {
  if (sweeps_.empty()) T_odom_origin_ = baseAtStamp(sweep);
  sweeps_.push_back(std::move(sweep));
  if (std::find(kRefineAt.begin(), kRefineAt.end(), sweeps_.size()) == kRefineAt.end())
    return false;
  Sweeps refined = sweeps_;
  VoxelHashMap refined_map = map;
  for (int round = 0; round < kRounds; ++round) {
    if (!refine(refined, refined_map)) return false;
  }
  sweeps_ = std::move(refined);
  map = std::move(refined_map);
  return true;
}

bool FirstSweeps::complete() const { return sweeps_.size() >= kRefineAt.back(); }

bool FirstSweeps::registerTo(const VoxelHashMap& map, MappedSweep& sweep) const {
  RegistrationPrior prior = prior_;
  prior.T_target_base = sweep.T_odom_middle;
  prior.motion = sweep.motion;
  const auto found = registerScan(sweep.surface, map, prior, params_, pool_);
  if (!found) return false;
  sweep.T_odom_middle = found->T_target_base;
  sweep.motion = found->motion;
  return true;
}

bool FirstSweeps::refine(Sweeps& sweeps, VoxelHashMap& map) const {
  correctCommonError(sweeps);
  fixOrigin(T_odom_origin_, sweeps);
  // The first sweep has only ever been looked at from the others.
  map.clear();
  for (std::size_t k = 1; k < sweeps.size(); ++k) insertSweep(sweeps[k], map);
  if (!registerTo(map, sweeps.front())) return false;
  map.clear();
  insertSweep(sweeps.front(), map);
  for (std::size_t k = 1; k < sweeps.size(); ++k) {
    if (!registerTo(map, sweeps[k])) return false;
    insertSweep(sweeps[k], map);
  }
  return true;
}

}  // namespace dynemo
