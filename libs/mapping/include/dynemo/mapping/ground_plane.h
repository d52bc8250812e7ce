#pragma once

#include <optional>
#include <vector>

#include "dynemo/perception/plane_extractor.h"

namespace dynemo {

/// The ground under the robot, in a frame at the base's origin with the axes of R_level_base.
struct GroundPlane {
  std::size_t observation = 0;        ///< which of the planes it is
  Vector3 normal = Vector3::UnitZ();  ///< unit, upwards
  double height_m = 0.0;              ///< z of the plane at the base's origin
};

/// Among the planes of one scan, the near-horizontal one that faces up and is nearest to the
/// expected height at the base's origin, or the lowest when nothing is expected; `R_level_base` is
/// the base's orientation in a frame that is level as far as known. Empty when no plane qualifies.
std::optional<GroundPlane> findGround(const std::vector<PlaneObservation>& planes,
                                      const Matrix3& R_level_base,
                                      std::optional<double> expected_height_m = std::nullopt);

/// The smallest rotation that turns the ground's normal upright.
Matrix3 levelling(const GroundPlane& ground);

}  // namespace dynemo
