#include "dynemo/core/point_cloud.h"

#include <gtest/gtest.h>

namespace dynemo::test {
namespace {

PointCloud organisedCloud(std::uint16_t n) {
  PointCloud cloud;
  cloud.rows = 1;
  cloud.columns = n;
  for (std::uint16_t i = 0; i < n; ++i) {
    cloud.points.emplace_back(i, 0, 0);
    cloud.time_offset_s.push_back(0.1f * static_cast<float>(i));
    cloud.row.push_back(0);
    cloud.column.push_back(i);
  }
  return cloud;
}

TEST(PointCloud, WithoutKeepsAttributesWithTheirPoints) {
  const std::vector<std::uint32_t> removed = {0, 2, 3, 9};
  const PointCloud kept = organisedCloud(10).without(removed);
  ASSERT_EQ(kept.size(), 6u);
  const std::uint16_t expected[] = {1, 4, 5, 6, 7, 8};
  for (std::size_t i = 0; i < kept.size(); ++i) {
    EXPECT_EQ(kept.points[i].x(), expected[i]);
    EXPECT_EQ(kept.column[i], expected[i]);
    EXPECT_FLOAT_EQ(kept.time_offset_s[i], 0.1f * expected[i]);
  }
  EXPECT_EQ(kept.columns, 10);
}

TEST(PointCloud, WithoutNothingIsTheSame) { EXPECT_EQ(organisedCloud(4).without({}).size(), 4u); }

TEST(PointCloud, WithoutEverythingIsEmpty) {
  const std::vector<std::uint32_t> all = {0, 1, 2, 3};
  EXPECT_TRUE(organisedCloud(4).without(all).empty());
}

TEST(PointCloud, IndicesBeyondTheEndAndRepeatedAreHarmless) {
  const std::vector<std::uint32_t> odd = {1, 1, 2, 77, 1000};
  EXPECT_EQ(organisedCloud(4).without(odd).size(), 2u);
}

TEST(PointCloud, PlainCloudStaysPlain) {
  PointCloud cloud;
  cloud.points.assign(3, Eigen::Vector3f::Zero());
  const std::vector<std::uint32_t> removed = {1};
  const PointCloud kept = cloud.without(removed);
  EXPECT_EQ(kept.size(), 2u);
  EXPECT_TRUE(kept.time_offset_s.empty());
  EXPECT_FALSE(kept.organised());
}

}  // namespace
}  // namespace dynemo::test
