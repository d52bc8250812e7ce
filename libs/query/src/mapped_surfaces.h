// Floors, walls and ceilings of a map, to ask whether a point lies on one.
#pragma once

#include <unordered_map>
#include <vector>

#include "dynemo/core/voxel.h"
#include "dynemo/graph/plane_patch.h"
#include "dynemo/graph/scene_graph.h"
#include "sight_counts.h"

namespace dynemo {

/// Planes count where they were seen, floors all over their area.
class MappedSurfaces {
 public:
  enum class Kind { kNone, kFloor, kPlane };

  MappedSurfaces(const CSceneGraph& graph, double tolerance_m);
  Kind at(const Vector3& p_map) const;

  /// What a scan sees of the planes, scans in order of time.
  void look(const BeamGrid& scan, const Pose3& T_map_lidar, const StructureParams& params);
  /// Takes out the parts of planes that scans see through: what a plane holds of an open door is
  /// who walked through it.
  void eraseSeenThrough(const StructureParams& params);

 private:
  struct SeenPlane {
    PlanePatch patch;
    Eigen::Matrix<double, 3, 2> axes;  ///< of its cells, per cell
    std::vector<Vector3> centers;      ///< of the patch's cells
    std::vector<SightCounts> sights;   ///< of the patch's cells
    Eigen::AlignedBox3d box;
  };
  void addPlane(PlanePatch patch);
  bool isOn(const SeenPlane& plane, const Vector3& p_map) const;

  double tolerance_m_;
  std::vector<SeenPlane> planes_;
  /// The planes that come near each coarse voxel.
  std::unordered_map<Eigen::Vector3i, std::vector<std::uint32_t>, VoxelHash> near_;
  struct Floor {
    double level_m;
    Eigen::AlignedBox2d area;
  };
  std::vector<Floor> floors_;
};

}  // namespace dynemo
