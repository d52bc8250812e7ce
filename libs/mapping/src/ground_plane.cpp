#include "dynemo/mapping/ground_plane.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <random>

namespace dynemo {
namespace {

constexpr double kRadius_m = 6.0;
constexpr double kMaxTilt_rad = 0.20;
constexpr double kInlierDistance_m = 0.03;
constexpr int kHypotheses = 200;
constexpr std::size_t kMaxSamples = 3000;
constexpr std::size_t kMinInliers = 60;

std::vector<Vector3> nearbyPointsBelow(const Scan& scan, const Matrix3& R_level_base) {
  std::vector<Vector3> points;
  for (const auto& p_lidar : scan.cloud.points) {
    const Vector3 p = R_level_base * (scan.T_base_lidar * p_lidar.cast<double>());
    if (p.head<2>().norm() < kRadius_m && p.z() < 0.3) points.push_back(p);
  }
  return points;
}

struct Plane {
  Vector3 normal = Vector3::UnitZ();
  double offset = 0.0;  ///< normal · p = offset
  double heightAtOrigin() const { return offset / normal.z(); }
  bool contains(const Vector3& p) const {
    return std::abs(normal.dot(p) - offset) < kInlierDistance_m;
  }
};

std::size_t countInliers(const std::vector<Vector3>& points, const Plane& plane) {
  return static_cast<std::size_t>(std::count_if(
      points.begin(), points.end(), [&](const Vector3& p) { return plane.contains(p); }));
}

Plane refined(const std::vector<Vector3>& points, const Plane& plane) {
  Vector3 mean = Vector3::Zero();
  Matrix3 moment = Matrix3::Zero();
  double n = 0;
  for (const Vector3& p : points) {
    if (!plane.contains(p)) continue;
    mean += p;
    moment += p * p.transpose();
    ++n;
  }
  mean /= n;
  const Eigen::SelfAdjointEigenSolver<Matrix3> es(moment / n - mean * mean.transpose());
  Plane out;
  out.normal = es.eigenvectors().col(0);
  if (out.normal.z() < 0) out.normal = -out.normal;
  out.offset = out.normal.dot(mean);
  return out;
}

}  // namespace

std::optional<GroundPlane> findGround(const Scan& scan, const Matrix3& R_level_base) {
  const std::vector<Vector3> all = nearbyPointsBelow(scan, R_level_base);
  if (all.size() < kMinInliers) return std::nullopt;
  std::vector<Vector3> samples;
  const std::size_t stride = all.size() / kMaxSamples + 1;
  for (std::size_t i = 0; i < all.size(); i += stride) samples.push_back(all[i]);

  std::mt19937 rng(1);  // fixed: the same scan gives the same ground
  Plane best;
  std::size_t best_count = 0;
  for (int i = 0; i < kHypotheses; ++i) {
    const Vector3 &a = samples[rng() % samples.size()], &b = samples[rng() % samples.size()],
                  &c = samples[rng() % samples.size()];
    Plane plane;
    plane.normal = (b - a).cross(c - a);
    if (plane.normal.norm() < 1e-3) continue;
    plane.normal.normalize();
    if (plane.normal.z() < 0) plane.normal = -plane.normal;
    if (plane.normal.z() < std::cos(kMaxTilt_rad)) continue;
    plane.offset = plane.normal.dot(a);
    const std::size_t count = countInliers(samples, plane);
    if (count > best_count) {
      best_count = count;
      best = plane;
    }
  }
  if (best_count * stride < kMinInliers) return std::nullopt;
  const Plane plane = refined(all, best);
  return GroundPlane{plane.normal, plane.heightAtOrigin()};
}

Matrix3 levelling(const GroundPlane& ground) {
  return Eigen::Quaterniond::FromTwoVectors(ground.normal, Vector3::UnitZ()).toRotationMatrix();
}

}  // namespace dynemo
