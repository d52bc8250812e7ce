#include "dynemo/odometry/voxel_hash_map.h"

#include <algorithm>
#include <array>
#include <limits>

namespace dynemo {
namespace {

/// Points per vector of the search loop.
constexpr std::size_t kLanes = 4;
constexpr std::size_t kMaxCapacity = 64;

}  // namespace

void fields(FieldVisitor& v, VoxelHashMapParams& p) {
  v.number("cell_m", p.cell_m, "Edge of a cell", {0.01, 10.0});
  v.integer("max_points_per_cell", p.max_points_per_cell, "Points kept per cell",
            Range::between(1, static_cast<double>(kMaxCapacity)));
  v.number("min_spacing_m", p.min_spacing_m,
           "Distance below which a further point of a cell adds nothing: without it dense points "
           "crowd out the rest",
           Range::nonNegative());
}

struct VoxelHashMap::Best {
  float distance2;
  std::uint32_t cell = CellIndex::kNone;
  std::uint32_t slot = 0;
};

VoxelHashMap::VoxelHashMap(const VoxelHashMapParams& params)
    : inverse_cell_m_(static_cast<float>(1.0 / params.cell_m)),
      cell_m_(static_cast<float>(params.cell_m)),
      min_spacing2_(static_cast<float>(params.min_spacing_m * params.min_spacing_m)),
      capacity_(static_cast<std::uint32_t>(params.max_points_per_cell)),
      padded_capacity_((capacity_ + kLanes - 1) / kLanes * kLanes),
      index_(4096) {}

std::uint32_t VoxelHashMap::addCell(const CellCoordinates& cell) {
  const std::uint32_t number = index_.findOrAdd(cell);
  if (number == counts_.size()) {
    coordinates_.push_back(cell);
    counts_.push_back(0);
    data_.resize(data_.size() + stride(), 0.0F);
  }
  return number;
}

bool VoxelHashMap::crowded(std::uint32_t cell, const Eigen::Vector3f& point,
                           const Eigen::Vector3f& normal) const {
  const float* d = cellData(cell);
  const std::size_t n = padded_capacity_;
  for (std::size_t i = 0; i < counts_[cell]; ++i) {
    const Eigen::Vector3f other(d[i], d[n + i], d[2 * n + i]);
    const Eigen::Vector3f other_normal(d[3 * n + i], d[4 * n + i], d[5 * n + i]);
    if ((other - point).squaredNorm() < min_spacing2_ && other_normal.dot(normal) > 0.0F)
      return true;
  }
  return false;
}

void VoxelHashMap::insert(const Eigen::Vector3f& point, const Eigen::Vector3f& normal) {
  const std::uint32_t cell = addCell(cellOf(point, inverse_cell_m_));
  if (counts_[cell] >= capacity_ || crowded(cell, point, normal)) return;
  float* d = cellData(cell) + counts_[cell]++;
  for (int axis = 0; axis < 3; ++axis) {
    d[static_cast<std::size_t>(axis) * padded_capacity_] = point[axis];
    d[static_cast<std::size_t>(axis + 3) * padded_capacity_] = normal[axis];
  }
}

void VoxelHashMap::insertFromLine(const Eigen::Vector3f& point, const Eigen::Vector3f& to_sensor,
                                  float elevation_rad) {
  const auto normal = lines_.add(point, elevation_rad);
  if (normal) insert(point, normal->dot(to_sensor) < 0.0F ? Eigen::Vector3f(-*normal) : *normal);
}

void VoxelHashMap::searchCell(std::uint32_t cell, const Eigen::Vector3f& p,
                              const Eigen::Vector3f& normal, float min_cosine, Best& best) const {
  const std::size_t n = padded_capacity_;
  const float* x = cellData(cell);
  const float *y = x + n, *z = y + n, *nx = z + n, *ny = nx + n, *nz = ny + n;
  std::array<float, kMaxCapacity> distance2;
  const std::size_t count = counts_[cell];
  const std::size_t padded = (count + kLanes - 1) / kLanes * kLanes;
  // Without branches, so that the compiler uses vector instructions.
  for (std::size_t i = 0; i < padded; ++i) {
    const float dx = x[i] - p.x(), dy = y[i] - p.y(), dz = z[i] - p.z();
    const float cosine = nx[i] * normal.x() + ny[i] * normal.y() + nz[i] * normal.z();
    const float d2 = dx * dx + dy * dy + dz * dz;
    distance2[i] = cosine >= min_cosine ? d2 : std::numeric_limits<float>::max();
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (distance2[i] >= best.distance2) continue;
    best = {distance2[i], cell, static_cast<std::uint32_t>(i)};
  }
}

bool VoxelHashMap::nearest(const Eigen::Vector3f& p, const Eigen::Vector3f& normal,
                           const CorrespondenceGate& gate, Correspondence& found) const {
  const CellCoordinates home = cellOf(p, inverse_cell_m_);
  Best best{gate.max_distance_m * gate.max_distance_m, CellIndex::kNone, 0};
  const auto visit = [&](const CellCoordinates& cell) {
    const std::uint32_t number = index_.find(cell);
    if (number != CellIndex::kNone) searchCell(number, p, normal, gate.min_normal_cosine, best);
  };
  visit(home);
  // Squared distance from p to the lower (0) and upper (1) face of its cell, per axis.
  std::array<std::array<float, 2>, 3> face2;
  for (int axis = 0; axis < 3; ++axis) {
    const float low = p[axis] - static_cast<float>(home[axis]) * cell_m_;
    face2[static_cast<std::size_t>(axis)] = {low * low, (cell_m_ - low) * (cell_m_ - low)};
  }
  for (int axis = 0; axis < 3; ++axis) {
    for (int side = 0; side < 2; ++side) {
      if (face2[static_cast<std::size_t>(axis)][static_cast<std::size_t>(side)] >= best.distance2)
        continue;
      CellCoordinates cell = home;
      cell[axis] += side == 0 ? -1 : 1;
      visit(cell);
    }
  }
  if (gate.wide) {
    for (int dx = -1; dx <= 1; ++dx)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dz = -1; dz <= 1; ++dz)
          if (dx * dx + dy * dy + dz * dz > 1) visit(home + CellCoordinates(dx, dy, dz));
  }
  if (best.cell == CellIndex::kNone) return false;
  const float* d = cellData(best.cell) + best.slot;
  const std::size_t n = padded_capacity_;
  found.point = {d[0], d[n], d[2 * n]};
  found.normal = {d[3 * n], d[4 * n], d[5 * n]};
  return true;
}

void VoxelHashMap::removeFartherThan(const Eigen::Vector3f& center, double radius_m) {
  const auto radius2 = static_cast<float>(radius_m * radius_m);
  CellIndex index(index_.size());
  std::uint32_t kept = 0;
  for (std::uint32_t cell = 0; cell < counts_.size(); ++cell) {
    const Eigen::Vector3f middle =
        (coordinates_[cell].cast<float>() + Eigen::Vector3f::Constant(0.5F)) * cell_m_;
    if ((middle - center).squaredNorm() > radius2) continue;
    index.findOrAdd(coordinates_[cell]);
    coordinates_[kept] = coordinates_[cell];
    counts_[kept] = counts_[cell];
    std::copy_n(cellData(cell), stride(), cellData(kept));
    ++kept;
  }
  coordinates_.resize(kept);
  counts_.resize(kept);
  data_.resize(kept * stride());
  index_ = std::move(index);
  lines_.removeFartherThan(center, radius_m);
}

void VoxelHashMap::clear() {
  index_.clear();
  coordinates_.clear();
  counts_.clear();
  data_.clear();
  lines_.clear();
}

std::size_t VoxelHashMap::points() const {
  std::size_t sum = 0;
  for (const std::uint32_t count : counts_) sum += count;
  return sum;
}

}  // namespace dynemo
