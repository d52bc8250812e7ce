// Ground and walls in the neighbourhood of one entity. Points are in a frame whose z axis points
// up; an error of some degrees in it is found and corrected.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "dynemo/perception/fragments.h"

namespace dynemo {

/// normal · p + offset = 0, unit normal.
struct LocalPlane {
  Eigen::Vector3f normal = Eigen::Vector3f::UnitZ();
  float offset = 0.0F;
  float distance(const Eigen::Vector3f& p) const { return normal.dot(p) + offset; }
};

/// The ground, normal up; horizontal through the expected height [m], or through the lowest points
/// when that is not known, where too few points show it.
LocalPlane findGround(std::span<const Eigen::Vector3f> points,
                      std::optional<double> expected_height_m, const FragmentParams& params);

/// Clears keep[i] of the points on upright planes that are long enough to be walls. Points with
/// keep[i] = 0 are ignored.
void dropWalls(std::span<const Eigen::Vector3f> points, const Eigen::Vector3f& up,
               const FragmentParams& params, std::vector<char>& keep);

}  // namespace dynemo
