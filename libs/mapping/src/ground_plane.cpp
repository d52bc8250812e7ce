#include "dynemo/mapping/ground_plane.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace dynemo {
namespace {

constexpr double kMaxTilt_rad = 0.20;
/// The ground may be this far from where it is expected, and above the base's origin.
constexpr double kMaxSurprise_m = 0.35, kMaxAboveBase_m = 0.1;

}  // namespace

std::optional<GroundPlane> findGround(const std::vector<PlaneObservation>& planes,
                                      const Matrix3& R_level_base,
                                      std::optional<double> expected_height_m) {
  std::optional<GroundPlane> best;
  double best_score = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < planes.size(); ++i) {
    const Plane3 plane_base = planes[i].patch_base.plane();
    const Vector3 normal = R_level_base * plane_base.normal;
    if (normal.z() < std::cos(kMaxTilt_rad)) continue;
    const double height_m = -plane_base.d_m / normal.z();
    if (height_m > kMaxAboveBase_m) continue;
    const double surprise_m = expected_height_m ? std::abs(height_m - *expected_height_m) : 0.0;
    if (surprise_m > kMaxSurprise_m) continue;
    const double score = expected_height_m ? surprise_m : height_m;
    if (score >= best_score) continue;
    best_score = score;
    best = GroundPlane{i, normal, height_m};
  }
  return best;
}

Matrix3 levelling(const GroundPlane& ground) {
  return Eigen::Quaterniond::FromTwoVectors(ground.normal, Vector3::UnitZ()).toRotationMatrix();
}

}  // namespace dynemo
