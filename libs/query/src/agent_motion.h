// How uncertain the place of an agent becomes while nobody sees it: its velocity is an
// Ornstein–Uhlenbeck process, so that it walks straight for a while and strays in the long run.
#pragma once

#include "dynemo/core/se3.h"
#include "dynemo/query/query_params.h"

namespace dynemo {

/// Variance of the displacement along each horizontal axis after a time [m²]:
/// 2 v² τ² (s + e⁻ˢ − 1) with s = t / τ.
double displacementVariance(double time_s, const QueryParams& params);

/// Variance of the heading after a time, up to that of the uniform distribution [rad²].
double headingVariance(double time_s, const QueryParams& params);

/// Adds motion in the map's horizontal plane and about the entity's own z to a tangent covariance.
Matrix6 withMotion(const Matrix6& covariance, const Matrix3& R_map_entity, double displacement_m2,
                   double heading_rad2);

/// P(displacement ≤ distance) of an isotropic normal displacement in the plane.
double probabilityWithin(double distance_m, double displacement_m2);

}  // namespace dynemo
