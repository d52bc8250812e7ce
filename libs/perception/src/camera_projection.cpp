#include "dynemo/perception/camera_projection.h"

#include <Eigen/LU>
#include <cmath>

namespace dynemo {
namespace {

using Matrix2 = Eigen::Matrix2d;
using Matrix23 = Eigen::Matrix<double, 2, 3>;

constexpr int kMaxNewtonSteps = 30;
constexpr double kNewtonTolerance = 1e-12;
constexpr double kMinDepth_m = 1e-6;

/// A distorted image point at focal length one, with its derivative.
struct Lens {
  Vector2 point;
  Matrix23 J;
};

/// Brown–Conrady with the rational denominator, on x = X/Z, y = Y/Z. The determinant of the
/// derivative is positive where the model is one-to-one.
struct PlumbBob {
  Vector2 point;
  Matrix2 J;
};

PlumbBob plumbBob(const std::array<double, 8>& k, const Vector2& n) {
  const double x = n.x(), y = n.y(), r2 = n.squaredNorm();
  const double k1 = k[0], k2 = k[1], p1 = k[2], p2 = k[3], k3 = k[4], k4 = k[5], k5 = k[6],
               k6 = k[7];
  const double above = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double below = 1.0 + r2 * (k4 + r2 * (k5 + r2 * k6));
  const double d_above = k1 + r2 * (2.0 * k2 + 3.0 * k3 * r2);
  const double d_below = k4 + r2 * (2.0 * k5 + 3.0 * k6 * r2);
  const double radial = above / below;
  const double d_radial = (d_above - radial * d_below) / below;  // by r²
  PlumbBob out;
  out.point = radial * n + Vector2(2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
                                   p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y);
  const double shared = 2.0 * d_radial * x * y + 2.0 * p1 * x + 2.0 * p2 * y;
  out.J << radial + 2.0 * d_radial * x * x + 2.0 * p1 * y + 6.0 * p2 * x, shared,  //
      shared, radial + 2.0 * d_radial * y * y + 6.0 * p1 * y + 2.0 * p2 * x;
  return out;
}

std::optional<Lens> throughPinhole(const CameraModel& camera, const Vector3& p) {
  if (!(p.z() > kMinDepth_m)) return std::nullopt;
  const Vector2 n = p.head<2>() / p.z();
  Matrix23 J_n_point;
  J_n_point << 1.0 / p.z(), 0.0, -n.x() / p.z(), 0.0, 1.0 / p.z(), -n.y() / p.z();
  if (camera.distortion == DistortionModel::kNone) return Lens{n, J_n_point};
  const PlumbBob d = plumbBob(camera.coefficients, n);
  if (!(d.J.determinant() > 0.0)) return std::nullopt;
  return Lens{d.point, d.J * J_n_point};
}

struct AngleMap {
  double radius, slope;
};

AngleMap kannalaBrandt(const std::array<double, 8>& k, double theta) {
  const double t2 = theta * theta;
  return {theta * (1.0 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3])))),
          1.0 + t2 * (3.0 * k[0] + t2 * (5.0 * k[1] + t2 * (7.0 * k[2] + t2 * 9.0 * k[3])))};
}

std::optional<Lens> throughFisheye(const CameraModel& camera, const Vector3& p) {
  const double r2 = p.head<2>().squaredNorm(), r = std::sqrt(r2), d2 = r2 + p.z() * p.z();
  if (!(d2 > kMinDepth_m * kMinDepth_m)) return std::nullopt;
  const double theta = std::atan2(r, p.z());
  const AngleMap map = kannalaBrandt(camera.coefficients, theta);
  if (!(map.slope > 0.0)) return std::nullopt;
  if (r < 1e-9 * std::abs(p.z())) {  // on the axis, where the direction of p.xy is undefined
    if (p.z() <= 0.0) return std::nullopt;
    Lens lens{p.head<2>() / p.z(), Matrix23::Zero()};
    lens.J(0, 0) = lens.J(1, 1) = 1.0 / p.z();
    return lens;
  }
  const Vector2 u = p.head<2>() / r;
  Lens lens;
  lens.point = map.radius * u;
  // dθ/dxy = u z/d², dθ/dz = −r/d²; du/dxy = (I − u uᵀ)/r.
  lens.J.leftCols<2>() = (map.slope * p.z() / d2) * u * u.transpose() +
                         (map.radius / r) * (Matrix2::Identity() - u * u.transpose());
  lens.J.col(2) = (-map.slope * r / d2) * u;
  return lens;
}

std::optional<Vector3> invertPlumbBob(const CameraModel& camera, const Vector2& distorted) {
  Vector2 n = distorted;
  for (int i = 0; i < kMaxNewtonSteps; ++i) {
    const PlumbBob d = plumbBob(camera.coefficients, n);
    if (!(d.J.determinant() > 0.0)) return std::nullopt;
    const Vector2 error = d.point - distorted;
    if (error.norm() < kNewtonTolerance) return n.homogeneous().normalized();
    n -= d.J.inverse() * error;
  }
  return std::nullopt;
}

std::optional<Vector3> invertKannalaBrandt(const CameraModel& camera, const Vector2& distorted) {
  const double radius = distorted.norm();
  double theta = radius;
  for (int i = 0; i < kMaxNewtonSteps; ++i) {
    const AngleMap map = kannalaBrandt(camera.coefficients, theta);
    if (!(map.slope > 0.0) || !(std::abs(theta) < M_PI)) return std::nullopt;
    const double error = map.radius - radius;
    if (std::abs(error) < kNewtonTolerance) {
      const Vector2 u = radius > 0.0 ? Vector2(distorted / radius) : Vector2::Zero();
      return Vector3(std::sin(theta) * u.x(), std::sin(theta) * u.y(), std::cos(theta));
    }
    theta -= error / map.slope;
  }
  return std::nullopt;
}

}  // namespace

std::optional<Projection> project(const CameraModel& camera, const Vector3& p_camera) {
  if (!p_camera.allFinite()) return std::nullopt;
  const auto lens = camera.distortion == DistortionModel::kKannalaBrandt
                        ? throughFisheye(camera, p_camera)
                        : throughPinhole(camera, p_camera);
  if (!lens) return std::nullopt;
  const Vector2 focal(camera.fx, camera.fy);
  return Projection{lens->point.cwiseProduct(focal) + Vector2(camera.cx, camera.cy),
                    focal.asDiagonal() * lens->J};
}

std::optional<Vector3> bearing(const CameraModel& camera, const Vector2& pixel) {
  if (!pixel.allFinite()) return std::nullopt;
  const Vector2 distorted((pixel.x() - camera.cx) / camera.fx, (pixel.y() - camera.cy) / camera.fy);
  switch (camera.distortion) {
    case DistortionModel::kPlumbBob:
      return invertPlumbBob(camera, distorted);
    case DistortionModel::kKannalaBrandt:
      return invertKannalaBrandt(camera, distorted);
    case DistortionModel::kNone:
      break;
  }
  return distorted.homogeneous().normalized();
}

}  // namespace dynemo
