#include "dynemo/odometry/surface_points.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "dynemo/odometry/cell_index.h"

namespace dynemo {
namespace {

/// A plane through fewer points says nothing about how flat they lie.
constexpr std::size_t kMinNeighbors = 5;
/// Two points always lie on a line.
constexpr std::size_t kMinOnLine = 3;
/// Of one ring, in elevation [about rad].
constexpr float kRingHeight = 0.01F;
/// Means within two leaves of one, all directions.
constexpr std::size_t kMaxNeighborhood = 125;
constexpr std::size_t kBlock = 256;

/// Sums are taken relative to the leaf's first point, so that single precision is enough.
struct Leaf {
  Eigen::Vector3f first;
  Eigen::Vector3f sum;
  float time_sum_s;
  float count;
};

struct Reduced {
  CellIndex index{8192};
  std::vector<CellCoordinates> coordinates;
  std::vector<Leaf> leaves;
};

Reduced reduce(const Scan& scan, std::span<const float> times_s, float reference_s,
               std::span<const std::uint32_t> ignored, const SurfaceParams& params) {
  Reduced reduced;
  const Eigen::Matrix3f R = scan.T_base_lidar.R.cast<float>();
  const Eigen::Vector3f t = scan.T_base_lidar.t.cast<float>();
  const auto min2 = static_cast<float>(params.min_range_m * params.min_range_m);
  const auto max2 = static_cast<float>(params.max_range_m * params.max_range_m);
  const auto inverse_leaf = static_cast<float>(1.0 / params.leaf_m);
  auto skip = ignored.begin();
  // Neighbours along a ring usually share a leaf.
  CellCoordinates last_cell = CellCoordinates::Constant(INT32_MAX);
  std::uint32_t number = 0;
  for (std::uint32_t i = 0; i < scan.cloud.size(); ++i) {
    while (skip != ignored.end() && *skip < i) ++skip;
    if (skip != ignored.end() && *skip == i) continue;
    const Eigen::Vector3f& p_lidar = scan.cloud.points[i];
    const float range2 = p_lidar.squaredNorm();
    if (!(range2 >= min2 && range2 <= max2)) continue;
    const Eigen::Vector3f p = R * p_lidar + t;
    const CellCoordinates cell = cellOf(p, inverse_leaf);
    if (cell != last_cell) {
      last_cell = cell;
      number = reduced.index.findOrAdd(cell);
      if (number == reduced.leaves.size()) {
        reduced.leaves.push_back({p, Eigen::Vector3f::Zero(), 0.0F, 0.0F});
        reduced.coordinates.push_back(cell);
      }
    }
    Leaf& leaf = reduced.leaves[number];
    leaf.sum += p - leaf.first;
    leaf.count += 1.0F;
    if (!times_s.empty()) leaf.time_sum_s += times_s[i] - reference_s;
  }
  return reduced;
}

SurfacePoints meansOf(const std::vector<Leaf>& leaves, bool timed) {
  SurfacePoints means;
  means.points.reserve(leaves.size());
  for (const Leaf& leaf : leaves) {
    means.points.push_back(leaf.first + leaf.sum / leaf.count);
    if (timed) means.time_s.push_back(leaf.time_sum_s / leaf.count);
  }
  return means;
}

/// The means in the cube of leaves around one, nearest first as far as the k-th.
class Neighborhood {
 public:
  Neighborhood(const Reduced& reduced, const std::vector<Eigen::Vector3f>& points, float radius_m)
      : reduced_(reduced), points_(points), radius2_(radius_m * radius_m) {}

  std::span<const std::uint32_t> nearest(std::uint32_t center, std::size_t k) {
    size_ = 0;
    for (int reach = 0; reach <= 2 && (reach < 2 || size_ < k); ++reach) addShell(center, reach);
    const std::size_t count = std::min(k, size_);
    if (count < size_) {
      std::nth_element(candidates_.begin(),
                       candidates_.begin() + static_cast<std::ptrdiff_t>(count),
                       candidates_.begin() + static_cast<std::ptrdiff_t>(size_));
    }
    for (std::size_t i = 0; i < count; ++i) result_[i] = candidates_[i].second;
    return {result_.data(), count};
  }

 private:
  /// Leaves at Chebyshev distance `reach`.
  void addShell(std::uint32_t center, int reach) {
    const CellCoordinates& c = reduced_.coordinates[center];
    for (int dx = -reach; dx <= reach; ++dx) {
      for (int dy = -reach; dy <= reach; ++dy) {
        const bool side = std::abs(dx) == reach || std::abs(dy) == reach;
        for (int dz = -reach; dz <= reach; dz += side ? 1 : 2 * reach) {
          addLeaf(center, reduced_.index.find(c + CellCoordinates(dx, dy, dz)));
        }
      }
    }
  }

  void addLeaf(std::uint32_t center, std::uint32_t leaf) {
    if (leaf == CellIndex::kNone) return;
    const float distance2 = (points_[leaf] - points_[center]).squaredNorm();
    if (distance2 <= radius2_) candidates_[size_++] = {distance2, leaf};
  }

  const Reduced& reduced_;
  const std::vector<Eigen::Vector3f>& points_;
  float radius2_;
  std::array<std::pair<float, std::uint32_t>, kMaxNeighborhood> candidates_;
  std::array<std::uint32_t, kMaxNeighborhood> result_;
  std::size_t size_ = 0;
};

/// Unit normal of the plane through the points, at least kMinNeighbors; empty when they form no
/// plane.
std::optional<Eigen::Vector3f> fitNormal(const std::vector<Eigen::Vector3f>& points,
                                         std::span<const std::uint32_t> members,
                                         float max_flatness) {
  const Eigen::Vector3f origin = points[members[0]];
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  Eigen::Matrix3f squares = Eigen::Matrix3f::Zero();
  for (const std::uint32_t i : members) {
    const Eigen::Vector3f d = points[i] - origin;
    sum += d;
    squares.noalias() += d * d.transpose();
  }
  const auto n = static_cast<float>(members.size());
  const Eigen::Matrix3f scatter = squares - sum * sum.transpose() / n;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver;
  solver.computeDirect(scatter);
  const Eigen::Vector3f& spread = solver.eigenvalues();
  if (!(spread[1] > 0.0F && spread[0] <= max_flatness * spread[1])) return std::nullopt;
  return solver.eigenvectors().col(0);
}

/// Ratio of the smaller to the larger variance of the directions in which the sensor sees the
/// points. Points of a single scan line always lie in a plane, the line's own, whatever they lie
/// on.
float viewSpread(const std::vector<Eigen::Vector3f>& points, std::span<const std::uint32_t> members,
                 const Eigen::Vector3f& sensor) {
  const Eigen::Vector3f center = (points[members[0]] - sensor).normalized();
  const Eigen::Vector3f u = center.unitOrthogonal();
  const Eigen::Vector3f v = center.cross(u);
  float su = 0, sv = 0, suu = 0, suv = 0, svv = 0;
  for (const std::uint32_t i : members) {
    const Eigen::Vector3f ray = points[i] - sensor;
    const float scale = 1.0F / ray.dot(center);
    const float a = ray.dot(u) * scale, b = ray.dot(v) * scale;
    su += a;
    sv += b;
    suu += a * a;
    suv += a * b;
    svv += b * b;
  }
  const auto n = static_cast<float>(members.size());
  suu -= su * su / n;
  suv -= su * sv / n;
  svv -= sv * sv / n;
  const float mean = 0.5F * (suu + svv);
  const float half_gap = std::hypot(0.5F * (suu - svv), suv);
  return mean + half_gap > 0.0F ? (mean - half_gap) / (mean + half_gap) : 0.0F;
}

/// Whether the sensor sees all at one elevation: a line across rings, as far down a corridor, is
/// what the sensor's columns draw, whatever it lies on.
bool onOneRing(const std::vector<Eigen::Vector3f>& points, std::span<const std::uint32_t> members,
               const Pose3& T_base_lidar) {
  const Eigen::Vector3f sensor = T_base_lidar.t.cast<float>();
  const Eigen::Vector3f up = T_base_lidar.R.col(2).cast<float>();
  float lowest = 1.0F, highest = -1.0F;
  for (const std::uint32_t i : members) {
    const float elevation = (points[i] - sensor).normalized().dot(up);
    lowest = std::min(lowest, elevation);
    highest = std::max(highest, elevation);
  }
  return highest - lowest < kRingHeight;
}

enum class Kind : std::uint8_t { kLeftOut, kSurface, kLine };

/// What each mean is part of; `still` are the means at one instant. Gives normals to those on
/// surfaces, and to those on lines the direction to the sensor.
std::vector<Kind> classify(const Reduced& reduced, const std::vector<Eigen::Vector3f>& still,
                           const Scan& scan, const SurfaceParams& params, SurfacePoints& means,
                           WorkerPool& pool) {
  const Eigen::Vector3f sensor = scan.T_base_lidar.t.cast<float>();
  std::vector<Kind> kinds(still.size(), Kind::kLeftOut);
  const auto min_spread = static_cast<float>(params.min_view_spread);
  pool.blocks(still.size(), kBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
    Neighborhood neighborhood(reduced, still, static_cast<float>(params.normal_radius_m));
    for (std::size_t i = begin; i < end; ++i) {
      const auto members = neighborhood.nearest(static_cast<std::uint32_t>(i),
                                                static_cast<std::size_t>(params.normal_neighbors));
      if (members.size() < kMinOnLine) continue;
      const Eigen::Vector3f to_sensor = sensor - still[i];
      if (viewSpread(still, members, sensor) < min_spread) {
        means.normals[i] = to_sensor.normalized();
        if (onOneRing(means.points, members, scan.T_base_lidar)) kinds[i] = Kind::kLine;
        continue;
      }
      if (members.size() < kMinNeighbors) continue;
      const auto normal = fitNormal(still, members, static_cast<float>(params.max_flatness));
      if (!normal) continue;
      means.normals[i] = normal->dot(to_sensor) < 0.0F ? Eigen::Vector3f(-*normal) : *normal;
      kinds[i] = Kind::kSurface;
    }
  });
  return kinds;
}

/// Appends the points of one kind, in order, and returns their number.
std::size_t append(const SurfacePoints& all, const std::vector<Kind>& kinds, Kind kind,
                   SurfacePoints& kept) {
  const std::size_t before = kept.size();
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (kinds[i] != kind) continue;
    kept.points.push_back(all.points[i]);
    kept.normals.push_back(all.normals[i]);
    if (all.timed()) kept.time_s.push_back(all.time_s[i]);
  }
  return kept.size() - before;
}

std::vector<Eigen::Vector3f> atReference(const SurfacePoints& means, const SweepMotion& motion) {
  if (!means.timed()) return means.points;
  const PointCarrier carrier(motion);
  std::vector<Eigen::Vector3f> points(means.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i] = carrier.toReference(means.time_s[i], means.points[i]);
  }
  return points;
}

}  // namespace

void fields(FieldVisitor& v, SurfaceParams& p) {
  v.number("min_range_m", p.min_range_m, "Nearer points are left out (the robot itself)",
           Range::nonNegative());
  v.number("max_range_m", p.max_range_m, "Farther points are left out", Range::positive());
  v.number("leaf_m", p.leaf_m, "Edge of the cubes whose points are averaged", {0.01, 10.0});
  v.integer("normal_neighbors", p.normal_neighbors,
            "Nearest averaged points, itself included, that a normal is fitted to",
            Range::between(static_cast<double>(kMinNeighbors), 60));
  v.number("normal_radius_m", p.normal_radius_m,
           "Farther points take no part in a fit, up to two leaves: scan lines wide apart would be "
           "joined to "
           "surfaces that do not exist",
           Range::positive());
  v.number("max_flatness", p.max_flatness,
           "Largest ratio of the smallest to the middle eigenvalue of the fit: above it the "
           "neighbours form a line or "
           "a blob and the point is left out",
           {0.0, 1.0, true});
  v.number("min_view_spread", p.min_view_spread,
           "Smallest ratio of the variances of the neighbours' directions seen from the sensor: "
           "below it they all "
           "belong to one scan line and the point is left out",
           Range::between(0.0, 1.0));
  v.flag("scan_lines", p.scan_lines,
         "Keep points of single scan lines, as sensors of few rings have them on the floor: they "
         "are registered to surfaces that the lines of several sweeps have shown");
}

SurfacePoints extractSurface(const Scan& scan, std::span<const float> times_s, double reference_s,
                             const SweepMotion& motion, std::span<const std::uint32_t> ignored,
                             const SurfaceParams& params, WorkerPool& pool) {
  const Reduced reduced = reduce(scan, times_s, static_cast<float>(reference_s), ignored, params);
  SurfacePoints means = meansOf(reduced.leaves, !times_s.empty());
  means.normals.assign(means.size(), Eigen::Vector3f::Zero());
  const std::vector<Kind> kinds =
      classify(reduced, atReference(means, motion), scan, params, means, pool);
  SurfacePoints surface;
  append(means, kinds, Kind::kSurface, surface);
  if (!params.scan_lines) return surface;
  surface.on_lines = append(means, kinds, Kind::kLine, surface);
  const Eigen::Matrix3f R_lidar_base = scan.T_base_lidar.R.transpose().cast<float>();
  for (std::size_t i = surface.onSurfaces(); i < surface.size(); ++i) {
    const float up = (R_lidar_base * surface.normals[i]).z();
    surface.line_elevation_rad.push_back(-std::asin(std::clamp(up, -1.0F, 1.0F)));
  }
  return surface;
}

}  // namespace dynemo
