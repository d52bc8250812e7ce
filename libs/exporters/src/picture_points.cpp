#include "picture_points.h"

#include <algorithm>
#include <cmath>

#include "dynemo/query/point_owners.h"
#include "entity_color.h"
#include "voxel_thinning.h"

namespace dynemo {
namespace {

/// Bluish grey, lighter with height, so that entities stand out.
std::uint32_t structureColor(double height_m, double cutaway_m) {
  const double share = cutaway_m > 0.0 ? std::clamp(height_m / cutaway_m, 0.0, 1.0) : 0.0;
  const auto mix = [share](double low, double high) {
    return static_cast<std::uint32_t>(std::lround(low + share * (high - low)));
  };
  return mix(120, 190) << 16u | mix(135, 205) << 8u | mix(160, 225);
}

void addKeyframe(const CNodeKeyframe& keyframe, const ScanOwners& owners,
                 const PictureParams& params, PicturePoints& clouds) {
  const Pose3& T_base_lidar = keyframe.scan->T_base_lidar;
  const auto& points = keyframe.scan->cloud.points;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3 p_base = T_base_lidar * points[i].cast<double>();
    const Eigen::Vector3f p_map = (keyframe.T_map_base() * p_base).cast<float>();
    if (const PlacedEntity* owner = owners.entity(i)) {
      clouds.fragments.push_back({p_map, entityRgb(owner->entity)});
    } else if (owners.isStructure(i) && p_base.z() <= params.cutaway_height_m) {
      clouds.structure.push_back({p_map, structureColor(p_base.z(), params.cutaway_height_m)});
    }
  }
}

}  // namespace

PicturePoints picturePoints(const RunResult& run, const ExportParams& params) {
  const PictureParams& picture = params.picture;
  const auto budget = static_cast<std::size_t>(picture.max_points);
  const PointOwners& owners = pointOwners(run, params.structure, params.query);
  PicturePoints clouds;
  for (const auto& keyframe : run.graph.keyframes()) {
    if (!keyframe->scan) continue;
    addKeyframe(*keyframe, owners.of(*keyframe), picture, clouds);
    // Thinning as it goes bounds the memory of long runs.
    for (auto* points : {&clouds.structure, &clouds.fragments}) {
      if (points->size() > 4 * budget)
        *points = withinBudget(std::move(*points), picture.voxel_m, budget);
    }
  }
  clouds.structure = withinBudget(std::move(clouds.structure), picture.voxel_m, budget);
  clouds.fragments = withinBudget(std::move(clouds.fragments), picture.voxel_m, budget);
  return clouds;
}

}  // namespace dynemo
