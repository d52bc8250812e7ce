#include "euclidean_clusters.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nanoflann.hpp>

namespace dynemo {
namespace {

using Eigen::Vector3f;

/// Cell side in units of the tolerance: dense scans become few cells, and gaps are measured to this
/// precision.
constexpr float kCellFraction = 0.2F;

struct CellCloud {
  std::vector<Vector3f> centres;
  std::vector<PointIndices> members;

  // nanoflann's dataset interface.
  std::size_t kdtree_get_point_count() const { return centres.size(); }
  float kdtree_get_pt(std::size_t i, std::size_t dim) const {
    return centres[i][static_cast<Eigen::Index>(dim)];
  }
  template <class BoundingBox>
  bool kdtree_get_bbox(BoundingBox&) const {
    return false;
  }
};

using KdTree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, CellCloud>,
                                                   CellCloud, 3, std::uint32_t>;

CellCloud makeCells(std::span<const Vector3f> points, float side_m) {
  std::vector<std::pair<std::array<int, 3>, std::uint32_t>> keyed;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3i cell = (points[i] / side_m).array().floor().cast<int>();
    keyed.push_back({{cell.x(), cell.y(), cell.z()}, i});
  }
  std::sort(keyed.begin(), keyed.end());
  CellCloud cells;
  for (std::size_t i = 0; i < keyed.size(); ++i) {
    if (i == 0 || keyed[i].first != keyed[i - 1].first) {
      cells.centres.push_back(Vector3f::Zero());
      cells.members.emplace_back();
    }
    cells.centres.back() += points[keyed[i].second];
    cells.members.back().push_back(keyed[i].second);
  }
  for (std::size_t i = 0; i < cells.centres.size(); ++i) {
    cells.centres[i] /= static_cast<float>(cells.members[i].size());
  }
  return cells;
}

/// All cells that can be reached from the seed; marks them.
PointIndices grow(const CellCloud& cells, const KdTree& tree, std::uint32_t seed, float tolerance_m,
                  std::vector<char>& visited) {
  PointIndices cluster;
  std::vector<std::uint32_t> open{seed};
  visited[seed] = 1;
  std::vector<std::pair<std::uint32_t, float>> near;
  while (!open.empty()) {
    const std::uint32_t cell = open.back();
    open.pop_back();
    cluster.insert(cluster.end(), cells.members[cell].begin(), cells.members[cell].end());
    tree.radiusSearch(cells.centres[cell].data(), tolerance_m * tolerance_m, near,
                      nanoflann::SearchParams(32, 0.0F, false));
    for (const auto& [neighbour, squared_distance] : near) {
      if (visited[neighbour]) continue;
      visited[neighbour] = 1;
      open.push_back(neighbour);
    }
  }
  std::sort(cluster.begin(), cluster.end());
  return cluster;
}

}  // namespace

std::vector<PointIndices> euclideanClusters(std::span<const Vector3f> points, float tolerance_m) {
  std::vector<PointIndices> clusters;
  if (points.empty()) return clusters;
  const CellCloud cells = makeCells(points, kCellFraction * tolerance_m);
  KdTree tree(3, cells, nanoflann::KDTreeSingleIndexAdaptorParams(10));
  tree.buildIndex();
  std::vector<char> visited(cells.centres.size(), 0);
  for (std::uint32_t seed = 0; seed < cells.centres.size(); ++seed) {
    if (!visited[seed]) clusters.push_back(grow(cells, tree, seed, tolerance_m, visited));
  }
  std::sort(clusters.begin(), clusters.end());
  return clusters;
}

}  // namespace dynemo
