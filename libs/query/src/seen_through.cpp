#include "seen_through.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace dynemo {
namespace {

constexpr int kBlock = 32;  ///< voxels
/// Points are on a surface when their spread across it is this small a share of that along it.
constexpr float kFlat = 0.2f;
constexpr float kFewestOnSurface = 8.0f;
int blockOf(int voxel) { return voxel >= 0 ? voxel / kBlock : -((-voxel + kBlock - 1) / kBlock); }

}  // namespace

SeenThrough::SeenThrough(const StructureParams& params)
    : params_(params), sight_{params.voxel_m, params.ray_radius_m, params.behind_m} {}

void SeenThrough::addPoint(const Vector3& p_map) {
  const Eigen::Vector3f p = p_map.cast<float>();
  const auto size_m = static_cast<float>(params_.voxel_m);
  const auto voxel = voxelOf(p, size_m);
  if (!voxel) return;
  const auto [it, added] = index_.try_emplace(*voxel, static_cast<std::uint32_t>(places_.size()));
  if (added) {
    voxels_.push_back(*voxel);
    places_.emplace_back();
  }
  Place& place = places_[it->second];
  const Eigen::Vector3f local = p - size_m * voxel->cast<float>();
  place.sum += local;
  place.squares += local * local.transpose();
  place.points += 1.0f;
}

const SeenThrough::Place* SeenThrough::find(const Eigen::Vector3i& voxel) const {
  const auto it = index_.find(voxel);
  return it == index_.end() ? nullptr : &places_[it->second];
}

void SeenThrough::findSurface(const Eigen::Vector3i& voxel, Place& place) const {
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  Eigen::Matrix3f squares = Eigen::Matrix3f::Zero();
  float points = 0.0f;
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        const Place* other = find(voxel + Eigen::Vector3i(x, y, z));
        if (!other) continue;
        const Eigen::Vector3f shift =
            static_cast<float>(params_.voxel_m) *
            Eigen::Vector3f(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
        sum += other->sum + other->points * shift;
        squares += other->squares + shift * other->sum.transpose() +
                   other->sum * shift.transpose() + other->points * shift * shift.transpose();
        points += other->points;
      }
    }
  }
  if (points < kFewestOnSurface) return;
  const Eigen::Vector3f mean = sum / points;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> spread(squares / points -
                                                              mean * mean.transpose());
  const Eigen::Vector3f deviations = spread.eigenvalues().cwiseMax(0.0f).cwiseSqrt();
  if (deviations[0] < kFlat * deviations[1]) place.normal = spread.eigenvectors().col(0);
}

void SeenThrough::prepare() {
  for (std::size_t i = 0; i < places_.size(); ++i) {
    Place& place = places_[i];
    place.middle =
        static_cast<float>(params_.voxel_m) * voxels_[i].cast<float>() + place.sum / place.points;
    findSurface(voxels_[i], place);
    blocks_[{blockOf(voxels_[i].x()), blockOf(voxels_[i].y()), blockOf(voxels_[i].z())}].push_back(
        static_cast<std::uint32_t>(i));
  }
}

void SeenThrough::look(const BeamGrid& scan, const Pose3& T_map_lidar) {
  const Pose3 T_lidar_map = T_map_lidar.inverse();
  const double block_m = kBlock * params_.voxel_m;
  const double reach_m = params_.max_range_m + std::sqrt(3.0) * block_m;
  for (const auto& [block, list] : blocks_) {
    const Vector3 corner = block_m * Vector3(block[0], block[1], block[2]);
    if ((corner - T_map_lidar.t).norm() > reach_m) continue;
    for (const std::uint32_t i : list) {
      Place& place = places_[i];
      const Vector3 from_lidar = place.middle.cast<double>() - T_map_lidar.t;
      const double range_m = from_lidar.norm();
      if (range_m > params_.max_range_m) continue;
      const Sight sight = scan.look(T_lidar_map * place.middle.cast<double>(), sight_);
      if (sight == Sight::kHit || isSteep(from_lidar / range_m, place.normal.cast<double>()))
        place.sights.add(sight);
    }
  }
}

Permanence SeenThrough::at(const Vector3& p_map) const {
  const auto voxel = voxelOf(p_map.cast<float>(), static_cast<float>(params_.voxel_m));
  const Place* place = voxel ? find(*voxel) : nullptr;
  return place ? place->sights.judge(params_) : Permanence::kUnknown;
}

}  // namespace dynemo
