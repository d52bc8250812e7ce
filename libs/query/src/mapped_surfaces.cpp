#include "mapped_surfaces.h"

#include <algorithm>
#include <cmath>

#include "dynemo/graph/seen_plane.h"

namespace dynemo {
namespace {

constexpr float kVoxel_m = PlanePatch::kCell_m;
/// The area of a floor is the box around what was seen of its walls: the ground goes a little
/// further, through doors.
constexpr double kAround_m = 2.0;

}  // namespace

MappedSurfaces::MappedSurfaces(const CSceneGraph& graph, double tolerance_m)
    : tolerance_m_(tolerance_m) {
  for (const auto& plane : graph.planes()) {
    if (plane->plane_map.isFinite()) addPlane(seenPatch(graph, *plane));
  }
  for (const auto& floor : graph.floors()) {
    if (!std::isfinite(floor->level_m) || floor->area_map_m.isEmpty()) continue;
    Eigen::AlignedBox2d area = floor->area_map_m;
    area.min().array() -= kAround_m;
    area.max().array() += kAround_m;
    floors_.push_back({floor->level_m, area});
  }
}

void MappedSurfaces::addPlane(PlanePatch patch) {
  const auto index = static_cast<std::uint32_t>(planes_.size());
  SeenPlane& plane = planes_.emplace_back();
  plane.axes = orthogonalBasis(patch.normal) / PlanePatch::kCell_m;
  plane.patch = std::move(patch);
  for (const Vector3& center : cellCenters(plane.patch)) {
    const auto voxel = voxelOf(center.cast<float>(), kVoxel_m);
    if (!voxel) continue;
    // All voxels around each cell: cells are as large as voxels, and turned.
    for (int x = -1; x <= 1; ++x) {
      for (int y = -1; y <= 1; ++y) {
        for (int z = -1; z <= 1; ++z) {
          std::uint32_t& number = index_[*voxel + Eigen::Vector3i(x, y, z)];
          if (number == VoxelIndex::kNone) {
            number = static_cast<std::uint32_t>(near_.size());
            near_.emplace_back();
          }
          auto& list = near_[number];
          if (list.empty() || list.back() != index) list.push_back(index);
        }
      }
    }
  }
}

bool MappedSurfaces::isOn(const SeenPlane& plane, const Vector3& p_map) const {
  const Vector3 from_center = p_map - plane.patch.center;
  if (std::abs(plane.patch.normal.dot(from_center)) > tolerance_m_) return false;
  const Vector2 at = plane.axes.transpose() * from_center;
  const std::array<std::int16_t, 2> cell{static_cast<std::int16_t>(std::floor(at.x())),
                                         static_cast<std::int16_t>(std::floor(at.y()))};
  return std::binary_search(plane.patch.cells.begin(), plane.patch.cells.end(), cell);
}

MappedSurfaces::Kind MappedSurfaces::at(const Vector3& p_map) const {
  for (const Floor& floor : floors_) {
    if (std::abs(p_map.z() - floor.level_m) <= tolerance_m_ &&
        floor.area.contains(p_map.head<2>())) {
      return Kind::kFloor;
    }
  }
  const auto voxel = voxelOf(p_map.cast<float>(), kVoxel_m);
  const std::uint32_t number = voxel ? index_.find(*voxel) : VoxelIndex::kNone;
  if (number == VoxelIndex::kNone) return Kind::kNone;
  for (const std::uint32_t i : near_[number]) {
    if (isOn(planes_[i], p_map)) return Kind::kPlane;
  }
  return Kind::kNone;
}

void MappedSurfaces::prepare(std::vector<Viewpoint> scans, const StructureParams& params) {
  std::vector<SeenPlace> cells;
  for (const SeenPlane& plane : planes_) {
    for (const Vector3& center : cellCenters(plane.patch))
      cells.push_back({center.cast<float>(), plane.patch.normal.cast<float>()});
  }
  const SightParams sight{0.5 * PlanePatch::kCell_m, params.ray_radius_m, params.behind_m};
  sights_ = {std::move(cells), std::move(scans), params, sight,
             PlaceSights::AlongSurface::kNothing};
}

bool MappedSurfaces::eraseSeenThrough() {
  bool any = false;
  std::size_t next = 0;
  for (SeenPlane& plane : planes_) {
    any |= std::erase_if(plane.patch.cells, [&](const auto&) {
             return sights_.at(next++) == Permanence::kPassing;
           }) > 0;
  }
  sights_ = {};
  return any;
}

}  // namespace dynemo
