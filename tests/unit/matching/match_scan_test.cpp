#include "dynemo/matching/match_scan.h"

#include <gtest/gtest.h>

#include "dynemo/matching/matching_params.h"
#include "scan_pair.h"

namespace dynemo {
namespace {

/// Indices of the points within `radius_m` of a place in the base frame.
PointIndices near(const Scan& scan, const Vector3& place_base, double radius_m) {
  PointIndices indices;
  for (std::uint32_t i = 0; i < scan.cloud.size(); ++i) {
    const Vector3 p = scan.T_base_lidar * scan.cloud.points[i].cast<double>();
    if ((p - place_base).norm() < radius_m) indices.push_back(i);
  }
  return indices;
}

TEST(MatchScan, LeavesOutTheLeavesOfRemovedPoints) {
  const Scan scan = test::roomPair().target;
  const MatchScan all(scan, MatchingParams().scan);
  const Vector3 place = all.surface().points[all.size() / 2].cast<double>();
  const PointIndices removed = near(scan, place, 0.8);
  ASSERT_GT(removed.size(), 20U);
  const MatchScan rest = all.without(scan, removed);
  EXPECT_LT(rest.size(), all.size());
  EXPECT_GT(rest.size(), all.size() / 2);
  const double leaf_m = MatchingParams().scan.leaf_m;
  for (const Eigen::Vector3f& p : rest.surface().points)
    EXPECT_GT((p.cast<double>() - place).norm(), 0.8 - leaf_m);
  // Everything farther from the removed points than a leaf's diagonal stays as it was.
  std::size_t far = 0;
  for (const Eigen::Vector3f& p : all.surface().points)
    far += (p.cast<double>() - place).norm() > 0.8 + 2.0 * leaf_m ? 1U : 0U;
  EXPECT_GE(rest.size(), far);
}

TEST(MatchScan, SearchesTheRemainingPointsOnly) {
  const Scan scan = test::roomPair().target;
  const MatchScan all(scan, MatchingParams().scan);
  const Eigen::Vector3f p = all.surface().points[all.size() / 2];
  const Eigen::Vector3f n = all.surface().normals[all.size() / 2];
  Correspondence found;
  ASSERT_TRUE(all.target().nearest(p, n, {0.5F, 0.0F, false}, found));
  EXPECT_EQ(found.point, p);
  const MatchScan rest = all.without(scan, near(scan, p.cast<double>(), 1.0));
  EXPECT_FALSE(rest.target().nearest(p, n, {0.5F, 0.0F, false}, found));
}

TEST(MatchScan, WithoutNothingIsTheSame) {
  const Scan scan = test::roomPair().target;
  const MatchScan all(scan, MatchingParams().scan);
  EXPECT_EQ(&all.without(scan, {}).surface(), &all.surface());
}

}  // namespace
}  // namespace dynemo
