#include "seen_through.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace dynemo {
namespace {

/// Points are on a surface when their spread across it is this small a share of that along it.
constexpr float kFlat = 0.2f;
constexpr float kFewestOnSurface = 8.0f;

}  // namespace

SeenThrough::SeenThrough(const StructureParams& params) : params_(params) {}

void SeenThrough::addPoint(const Vector3& p_map) {
  const Eigen::Vector3f p = p_map.cast<float>();
  const auto size_m = static_cast<float>(params_.voxel_m);
  const auto voxel = voxelOf(p, size_m);
  if (!voxel) return;
  std::uint32_t& number = index_[*voxel];
  if (number == VoxelIndex::kNone) {
    number = static_cast<std::uint32_t>(spreads_.size());
    voxels_.push_back(*voxel);
    spreads_.emplace_back();
  }
  Spread& spread = spreads_[number];
  const Eigen::Vector3f local = p - size_m * voxel->cast<float>();
  spread.sum += local;
  spread.squares += local * local.transpose();
  spread.points += 1.0f;
}

Eigen::Vector3f SeenThrough::normalAt(const Eigen::Vector3i& voxel) const {
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  Eigen::Matrix3f squares = Eigen::Matrix3f::Zero();
  float points = 0.0f;
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        const std::uint32_t number = index_.find(voxel + Eigen::Vector3i(x, y, z));
        if (number == VoxelIndex::kNone) continue;
        const Spread& other = spreads_[number];
        const Eigen::Vector3f shift =
            static_cast<float>(params_.voxel_m) *
            Eigen::Vector3f(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
        sum += other.sum + other.points * shift;
        squares += other.squares + shift * other.sum.transpose() + other.sum * shift.transpose() +
                   other.points * shift * shift.transpose();
        points += other.points;
      }
    }
  }
  if (points < kFewestOnSurface) return Eigen::Vector3f::Zero();
  const Eigen::Vector3f mean = sum / points;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> spread(squares / points -
                                                              mean * mean.transpose());
  const Eigen::Vector3f deviations = spread.eigenvalues().cwiseMax(0.0f).cwiseSqrt();
  if (deviations[0] >= kFlat * deviations[1]) return Eigen::Vector3f::Zero();
  return spread.eigenvectors().col(0);
}

void SeenThrough::prepare(std::vector<Viewpoint> scans) {
  const auto size_m = static_cast<float>(params_.voxel_m);
  std::vector<SeenPlace> places;
  places.reserve(spreads_.size());
  for (std::size_t i = 0; i < spreads_.size(); ++i) {
    const Eigen::Vector3f mean = spreads_[i].sum / spreads_[i].points;
    places.push_back({size_m * voxels_[i].cast<float>() + mean, normalAt(voxels_[i])});
  }
  const SightParams sight{params_.voxel_m, params_.ray_radius_m, params_.behind_m};
  sights_ = {std::move(places), std::move(scans), params_, sight, PlaceSights::AlongSurface::kHits};
  voxels_ = {};
  spreads_ = {};
}

Permanence SeenThrough::at(const Vector3& p_map) const {
  const auto voxel = voxelOf(p_map.cast<float>(), static_cast<float>(params_.voxel_m));
  const std::uint32_t number = voxel ? index_.find(*voxel) : VoxelIndex::kNone;
  return number < sights_.size() ? sights_.at(number) : Permanence::kUnknown;
}

}  // namespace dynemo
