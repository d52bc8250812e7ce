#include "plane_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace dynemo {
namespace {

/// Segments whose mean distance from a common plane stays within so many sigmas are of one plane.
constexpr double kJoinSigmas = 1.5;
const double kJoinCosine = std::cos(0.26);
/// Besides the noise of the ranges: rounding, and the size of the beam.
constexpr double kPointSigma_m = 0.002;

/// The grid of a patch under points of a scan, with the patch and T_frame_lidar in the same frame.
void fillCells(PlanePatch& patch, const PointCloud& cloud, const PointIndices& points,
               const Pose3& T_frame_lidar) {
  const Eigen::Matrix<double, 2, 3> BT =
      orthogonalBasis(patch.normal).transpose() / PlanePatch::kCell_m;
  const Eigen::Matrix<float, 2, 3> A = (BT * T_frame_lidar.R).cast<float>();
  const Eigen::Vector2f b = (BT * (T_frame_lidar.t - patch.center)).cast<float>();
  const auto cell = [](float v) {
    return static_cast<std::int16_t>(std::clamp(std::floor(v), -32000.0F, 32000.0F));
  };
  auto& cells = patch.cells;
  cells.clear();
  for (const std::uint32_t i : points) {
    const Eigen::Vector2f q = A * cloud.points[i] + b;
    const std::array<std::int16_t, 2> at = {cell(q.x()), cell(q.y())};
    if (cells.empty() || cells.back() != at) cells.push_back(at);
  }
  std::sort(cells.begin(), cells.end());
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
}

PlanePatch patchOf(const PointCloud& cloud, const PlaneSegment& segment) {
  const MomentFit fit = fitMoments(segment.moments);
  PlanePatch patch;
  patch.center = fit.mean;
  patch.normal =
      fit.plane.normal.dot(fit.mean) > 0.0 ? Vector3(-fit.plane.normal) : fit.plane.normal;
  fillCells(patch, cloud, segment.points, Pose3());
  return patch;
}

bool isOnePlane(const PlaneSegment& a, const PlanePatch& patch_a, const PlaneSegment& b,
                const PlanePatch& patch_b, double sigma_m, double max_gap_m) {
  if (patch_a.normal.dot(patch_b.normal) < kJoinCosine) return false;
  Moments both = a.moments;
  both += b.moments;
  const MomentFit fit = fitMoments(both);
  const double limit_m2 = kJoinSigmas * kJoinSigmas * sigma_m * sigma_m;
  if (a.moments.meanSquare(fit.plane) > limit_m2 || b.moments.meanSquare(fit.plane) > limit_m2)
    return false;
  return withinGap(cellCenters(patch_a), cellCenters(patch_b), max_gap_m);
}

void append(PlaneSegment& to, const PlaneSegment& from) {
  PointIndices all(to.points.size() + from.points.size());
  std::merge(to.points.begin(), to.points.end(), from.points.begin(), from.points.end(),
             all.begin());
  to.points = std::move(all);
  to.moments += from.moments;
}

std::vector<PlaneSegment> joined(const PointCloud& cloud, std::vector<PlaneSegment> segments,
                                 double sigma_m, double max_gap_m) {
  std::vector<PlanePatch> patches;
  for (const auto& segment : segments) patches.push_back(patchOf(cloud, segment));
  for (std::size_t i = 0; i < segments.size(); ++i) {
    for (std::size_t j = i + 1; j < segments.size();) {
      if (!isOnePlane(segments[i], patches[i], segments[j], patches[j], sigma_m, max_gap_m)) {
        ++j;
        continue;
      }
      append(segments[i], segments[j]);
      segments.erase(segments.begin() + static_cast<std::ptrdiff_t>(j));
      patches.erase(patches.begin() + static_cast<std::ptrdiff_t>(j));
      patches[i] = patchOf(cloud, segments[i]);
      j = i + 1;
    }
  }
  return segments;
}

bool largeEnough(const PlaneSegment& segment, const PlaneParams& params) {
  if (static_cast<int>(segment.points.size()) < params.min_points) return false;
  // The length of a uniformly covered strip from its variance.
  const MomentFit fit = fitMoments(segment.moments);
  return std::sqrt(12.0 * fit.spread_m2[2]) >= params.min_length_m &&
         std::sqrt(12.0 * fit.spread_m2[1]) >= params.min_width_m;
}

/// Weighted least squares: the noise of a range moves its point along the ray, of which only the
/// part along the normal counts. Returns the observation in the sensor's frame.
PlaneObservation fitted(const PointCloud& cloud, PlaneSegment segment, double range_sigma_m) {
  const Vector3 first_normal = fitMoments(segment.moments).plane.normal;
  const double range_variance = range_sigma_m * range_sigma_m,
               point_variance = kPointSigma_m * kPointSigma_m;
  double sum_w = 0.0;
  Vector3 sum = Vector3::Zero();
  Matrix3 squares = Matrix3::Zero();
  const auto weightOf = [&](const Vector3& p) {
    const double along = first_normal.dot(p);
    return 1.0 / (range_variance * along * along / p.squaredNorm() + point_variance);
  };
  for (const std::uint32_t i : segment.points) {
    const Vector3 p = cloud.points[i].cast<double>();
    const double w = weightOf(p);
    sum_w += w;
    sum += w * p;
    squares.noalias() += w * p * p.transpose();
  }
  PlaneObservation out;
  out.patch_base.center = sum / sum_w;
  const Matrix3 scatter = squares - sum * sum.transpose() / sum_w;
  const Eigen::SelfAdjointEigenSolver<Matrix3> eigen(scatter);
  Vector3 normal = eigen.eigenvectors().col(0);
  if (normal.dot(out.patch_base.center) > 0.0) normal = -normal;
  out.patch_base.normal = normal;

  const double dof = static_cast<double>(segment.points.size()) - 3.0;
  const double inflation = std::max(1.0, eigen.eigenvalues()[0] / dof);
  const Eigen::Matrix<double, 3, 2> B = orthogonalBasis(normal);
  out.covariance.setZero();
  out.covariance.topLeftCorner<2, 2>() = inflation * (B.transpose() * scatter * B).inverse();
  out.covariance(2, 2) = inflation / sum_w;
  out.rms_m = std::sqrt(segment.moments.meanSquare(out.patch_base.plane()));
  out.points = std::move(segment.points);
  return out;
}

/// To the base frame. The tangent basis of the turned normal is not the turned basis.
void carryToBase(const Pose3& T_base_lidar, const PointCloud& cloud, PlaneObservation& o) {
  const Eigen::Matrix<double, 3, 2> B_lidar = orthogonalBasis(o.patch_base.normal);
  o.patch_base.normal = (T_base_lidar.R * o.patch_base.normal).normalized();
  o.patch_base.center = T_base_lidar * o.patch_base.center;
  Matrix3 turn = Matrix3::Identity();
  turn.topLeftCorner<2, 2>() =
      orthogonalBasis(o.patch_base.normal).transpose() * T_base_lidar.R * B_lidar;
  o.covariance = turn * o.covariance * turn.transpose();
  o.covariance = 0.5 * (o.covariance + o.covariance.transpose()).eval();
  fillCells(o.patch_base, cloud, o.points, T_base_lidar);
}

}  // namespace

bool isFaceOf(const PlaneObservation& plane, const PointIndices& fragment) {
  PointIndices common;
  std::set_intersection(plane.points.begin(), plane.points.end(), fragment.begin(), fragment.end(),
                        std::back_inserter(common));
  return 2 * common.size() > plane.points.size();
}

double MomentFit::varianceAt(const Vector3& p, double n) const {
  const Vector3 q = axes.transpose() * (p - mean);
  return (1.0 + q[1] * q[1] / std::max(spread_m2[1], 1e-6) +
          q[2] * q[2] / std::max(spread_m2[2], 1e-6)) /
         n;
}

MomentFit fitMoments(const Moments& moments) {
  Eigen::SelfAdjointEigenSolver<Matrix3> eigen;
  eigen.computeDirect(moments.scatter());
  MomentFit fit;
  fit.mean = moments.mean();
  fit.axes = eigen.eigenvectors();
  fit.spread_m2 = eigen.eigenvalues().cwiseMax(0.0);
  fit.plane = Plane3::through(fit.mean, fit.axes.col(0));
  fit.rms_m = std::sqrt(fit.spread_m2[0]);
  return fit;
}

std::vector<PlaneObservation> observePlanes(const Scan& scan, std::vector<PlaneSegment> segments,
                                            double range_sigma_m, const PlaneParams& params) {
  std::stable_sort(segments.begin(), segments.end(),
                   [](const auto& a, const auto& b) { return a.points.size() > b.points.size(); });
  segments = joined(scan.cloud, std::move(segments), range_sigma_m, params.max_gap_m);
  std::vector<PlaneObservation> observations;
  for (PlaneSegment& segment : segments) {
    if (!largeEnough(segment, params)) continue;
    PlaneObservation o = fitted(scan.cloud, std::move(segment), range_sigma_m);
    carryToBase(scan.T_base_lidar, scan.cloud, o);
    o.covariance.diagonal() +=
        Vector3(params.min_sigma_normal_rad, params.min_sigma_normal_rad, params.min_sigma_offset_m)
            .array()
            .square()
            .matrix();
    observations.push_back(std::move(o));
  }
  std::stable_sort(observations.begin(), observations.end(),
                   [](const auto& a, const auto& b) { return a.points.size() > b.points.size(); });
  return observations;
}

}  // namespace dynemo
