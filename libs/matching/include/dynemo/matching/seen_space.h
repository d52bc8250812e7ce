// The space that a scan has seen to be free.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "dynemo/core/se3.h"

namespace dynemo {

/// The nearest return in each direction from the sensor, in cells of about two degrees. A wrong
/// pose may fit every surface it overlaps with (a corridor slid along itself, the next room) and
/// still put surfaces where the sensor looked through.
class SeenSpace {
 public:
  /// Points and sensor in one frame, the base's [m].
  SeenSpace(std::span<const Eigen::Vector3f> points, const Eigen::Vector3f& sensor);

  /// Of the points that lie in directions with returns, the share that lies clearly in front of
  /// all returns around there, in [0, 1]; 0 when there are none. T_base_other poses the points'
  /// frame.
  double contradicted(std::span<const Eigen::Vector3f> points_other,
                      const Pose3& T_base_other) const;

 private:
  /// Range of a direction's cell and of its neighbours; empty when the cell itself has no return.
  std::optional<float> freeRange_m(const Eigen::Vector3f& ray) const;

  Eigen::Vector3f sensor_;
  std::vector<float> nearest_m_;
};

}  // namespace dynemo
