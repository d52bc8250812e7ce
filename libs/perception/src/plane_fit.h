// From points that belong together to plane observations: fit, covariance, joining and selection.
#pragma once

#include <Eigen/Core>

#include "dynemo/perception/plane_extractor.h"

namespace dynemo {

/// Sums over points that tell how well any plane fits them.
struct Moments {
  double n = 0.0;
  Vector3 sum = Vector3::Zero();
  Matrix3 squares = Matrix3::Zero();

  void add(const Vector3& p) {
    n += 1.0;
    sum += p;
    squares.noalias() += p * p.transpose();
  }
  Moments& operator+=(const Moments& other) {
    n += other.n;
    sum += other.sum;
    squares += other.squares;
    return *this;
  }
  Vector3 mean() const { return sum / n; }
  Matrix3 scatter() const { return squares / n - mean() * mean().transpose(); }
  /// Mean squared distance of the points from a plane.
  double meanSquare(const Plane3& plane) const {
    const double offset = plane.distance(mean());
    return std::max(0.0, plane.normal.dot(scatter() * plane.normal)) + offset * offset;
  }
};

/// The best plane through the points, unweighted, with what it leaves and how certain it is
/// elsewhere.
struct MomentFit {
  Plane3 plane;
  double rms_m = 0.0;
  Vector3 mean = Vector3::Zero();
  Matrix3 axes = Matrix3::Identity();   ///< columns: normal, short axis, long axis
  Vector3 spread_m2 = Vector3::Zero();  ///< variance of the points along them

  /// Variance of the distance between the fitted and the true plane at p, for points of unit noise.
  double varianceAt(const Vector3& p, double n) const;
};
MomentFit fitMoments(const Moments& moments);

/// The points of the scan that one plane explains, in the frame of the sensor.
struct PlaneSegment {
  PointIndices points;
  Moments moments;
};

/// Joins the segments of one plane, leaves out what is too small, fits the rest with the noise of
/// the ranges and carries it to the base frame. Segments are given in a fixed order.
std::vector<PlaneObservation> observePlanes(const Scan& scan, std::vector<PlaneSegment> segments,
                                            double range_sigma_m, const PlaneParams& params);

}  // namespace dynemo
