// Floors, walls and ceilings of a map, to ask whether a point lies on one.
#pragma once

#include <vector>

#include "dynemo/graph/plane_patch.h"
#include "dynemo/graph/scene_graph.h"
#include "place_sights.h"
#include "voxel_index.h"

namespace dynemo {

/// Planes count where they were seen, floors all over their area.
class MappedSurfaces {
 public:
  enum class Kind { kNone, kFloor, kPlane };

  MappedSurfaces(const CSceneGraph& graph, double tolerance_m);
  Kind at(const Vector3& p_map) const;

  /// Scans shall look at the planes.
  void prepare(std::vector<Viewpoint> scans, const StructureParams& params);
  PlaceSights& sights() { return sights_; }
  /// Takes out the parts of planes that scans see through: what a plane holds of an open door is
  /// who walked through it. Returns whether there were any.
  bool eraseSeenThrough();

 private:
  struct SeenPlane {
    PlanePatch patch;
    Eigen::Matrix<double, 3, 2> axes;  ///< of its cells, per cell
  };
  void addPlane(PlanePatch patch);
  bool isOn(const SeenPlane& plane, const Vector3& p_map) const;

  double tolerance_m_;
  std::vector<SeenPlane> planes_;
  PlaceSights sights_;  ///< of the cells of all planes in their order, while scans look
  VoxelIndex index_;    ///< of coarse voxels
  /// The planes that come near each of them.
  std::vector<std::vector<std::uint32_t>> near_;
  struct Floor {
    double level_m;
    Eigen::AlignedBox2d area;
  };
  std::vector<Floor> floors_;
};

}  // namespace dynemo
