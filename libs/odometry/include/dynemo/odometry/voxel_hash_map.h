// The local map: surface points in the cells of a sparse grid.
#pragma once

#include <cstdint>
#include <vector>

#include "dynemo/core/fields.h"
#include "dynemo/odometry/cell_index.h"
#include "dynemo/odometry/registration_target.h"
#include "dynemo/odometry/scan_line_points.h"

namespace dynemo {

struct VoxelHashMapParams {
  double cell_m = 0.5;
  int max_points_per_cell = 20;
  double min_spacing_m = 0.1;
};
void fields(FieldVisitor& v, VoxelHashMapParams& p);

/// Points with normals in cubic cells. A cell keeps the points that came first, at least
/// `min_spacing_m` apart and facing the same way (the two faces of a thin wall share a cell), up to
/// its capacity. Searches look into the point's cell and the six that share a face with it; a
/// nearer point across an edge or a corner is only found by a wide search, which is exact for
/// distances up to one cell.
class VoxelHashMap final : public RegistrationTarget {
 public:
  explicit VoxelHashMap(const VoxelHashMapParams& params);

  void insert(const Eigen::Vector3f& point, const Eigen::Vector3f& normal);
  /// A point of a single scan line: part of the map once other lines show the surface it is on.
  void insertFromLine(const Eigen::Vector3f& point, const Eigen::Vector3f& to_sensor,
                      float elevation_rad);
  /// Before the points of each sweep.
  void beginSweep() { lines_.beginSweep(); }
  bool nearest(const Eigen::Vector3f& p, const Eigen::Vector3f& normal,
               const CorrespondenceGate& gate, Correspondence& found) const override;

  /// Forgets the cells whose centre is farther than radius_m from `center`.
  void removeFartherThan(const Eigen::Vector3f& center, double radius_m);
  void clear();
  std::size_t cells() const { return index_.size(); }
  std::size_t points() const;

 private:
  struct Best;
  float* cellData(std::uint32_t cell) { return data_.data() + cell * stride(); }
  const float* cellData(std::uint32_t cell) const { return data_.data() + cell * stride(); }
  /// x, y, z, nx, ny, nz, each padded to full vectors.
  std::size_t stride() const { return 6 * padded_capacity_; }
  std::uint32_t addCell(const CellCoordinates& cell);
  bool crowded(std::uint32_t cell, const Eigen::Vector3f& point,
               const Eigen::Vector3f& normal) const;
  void searchCell(std::uint32_t cell, const Eigen::Vector3f& p, const Eigen::Vector3f& normal,
                  float min_cosine, Best& best) const;

  float inverse_cell_m_;
  float cell_m_;
  float min_spacing2_;
  std::uint32_t capacity_;
  std::size_t padded_capacity_;
  CellIndex index_;
  std::vector<CellCoordinates> coordinates_;
  std::vector<std::uint32_t> counts_;
  std::vector<float> data_;
  ScanLinePoints lines_;
};

}  // namespace dynemo
