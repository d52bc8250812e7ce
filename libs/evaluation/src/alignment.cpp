#include "dynemo/evaluation/alignment.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cstdlib>

namespace dynemo {
namespace {

constexpr std::size_t kMinPoints = 3;
/// Singular values of the covariance below this share of the largest count as zero.
constexpr double kRankTolerance = 1e-12;

Vector3 centroid(std::span<const Vector3> points) {
  Vector3 sum = Vector3::Zero();
  for (const Vector3& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

std::size_t nearest(const Trajectory& trajectory, Stamp stamp) {
  const auto after =
      std::lower_bound(trajectory.begin(), trajectory.end(), stamp,
                       [](const StampedPose& pose, Stamp s) { return pose.stamp < s; });
  if (after == trajectory.begin()) return 0;
  const auto before = after - 1;
  const bool take_before =
      after == trajectory.end() || stamp.ns - before->stamp.ns <= after->stamp.ns - stamp.ns;
  return static_cast<std::size_t>((take_before ? before : after) - trajectory.begin());
}

}  // namespace

std::vector<PosePair> associate(const Trajectory& reference, const Trajectory& estimate,
                                double max_difference_s) {
  const bool by_estimate = estimate.size() <= reference.size();
  const Trajectory& shorter = by_estimate ? estimate : reference;
  const Trajectory& longer = by_estimate ? reference : estimate;
  std::vector<PosePair> pairs;
  if (longer.empty()) return pairs;
  for (std::size_t i = 0; i < shorter.size(); ++i) {
    const std::size_t j = nearest(longer, shorter[i].stamp);
    if (std::abs(secondsBetween(longer[j].stamp, shorter[i].stamp)) > max_difference_s) continue;
    pairs.push_back(by_estimate ? PosePair{j, i} : PosePair{i, j});
  }
  return pairs;
}

const char* alignmentFailureText(AlignmentFailure failure) {
  switch (failure) {
    case AlignmentFailure::kTooFewPoints:
      return "fewer than three poses have corresponding stamps";
    case AlignmentFailure::kDegenerate:
      return "all positions lie on one line or in one point, so that no rotation is determined";
  }
  return "unknown";
}

Expected<Pose3, AlignmentFailure> alignPoints(std::span<const Vector3> reference,
                                              std::span<const Vector3> estimate) {
  if (reference.size() < kMinPoints || reference.size() != estimate.size()) {
    return make_unexpected(AlignmentFailure::kTooFewPoints);
  }
  const Vector3 mean_reference = centroid(reference), mean_estimate = centroid(estimate);
  Matrix3 covariance = Matrix3::Zero();
  for (std::size_t i = 0; i < reference.size(); ++i) {
    covariance += (reference[i] - mean_reference) * (estimate[i] - mean_estimate).transpose();
  }
  covariance /= static_cast<double>(reference.size());
  const Eigen::JacobiSVD<Matrix3> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Vector3 d = svd.singularValues();
  if (!(d[1] > kRankTolerance * d[0])) return make_unexpected(AlignmentFailure::kDegenerate);
  // A reflection would fit better where this determinant is negative: Eq. (39).
  Vector3 signs = Vector3::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0) signs.z() = -1.0;
  Pose3 T;
  T.R = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  T.t = mean_reference - T.R * mean_estimate;
  return T;
}

Trajectory transformed(const Trajectory& trajectory, const Pose3& T_reference_estimate) {
  Trajectory out = trajectory;
  for (StampedPose& pose : out) pose.T = T_reference_estimate * pose.T;
  return out;
}

}  // namespace dynemo
