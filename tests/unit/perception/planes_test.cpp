// Planes of made-up rooms, of which every wall is known.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "dynemo/core/noise.h"
#include "dynemo/perception/plane_extractor.h"
#include "dynemo/perception/range_image.h"
#include "synthetic_world.h"

namespace dynemo {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180.0;
constexpr double kMaxAngle_rad = 0.2 * kDegree, kMaxOffset_m = 0.004;

/// Points in the order of the sweep, column by column, with their rows and columns: every ray of a
/// closed room comes back.
Scan organisedSweep(const test::World& world, const Pose3& T_world_base, test::LidarModel lidar) {
  lidar.sweep_s = 0.0;
  std::mt19937_64 random(7);
  Scan scan = test::sweep(
      world, lidar, [&](double) { return T_world_base; }, 0.0, random);
  scan.cloud.rows = static_cast<std::uint16_t>(lidar.rows);
  scan.cloud.columns = static_cast<std::uint16_t>(lidar.columns);
  EXPECT_EQ(scan.cloud.size(), static_cast<std::size_t>(lidar.rows * lidar.columns));
  for (std::size_t i = 0; i < scan.cloud.size(); ++i) {
    scan.cloud.row.push_back(static_cast<std::uint16_t>(i % scan.cloud.rows));
    scan.cloud.column.push_back(static_cast<std::uint16_t>(i / scan.cloud.rows));
  }
  return scan;
}

/// The same points as a bare list, ring by ring; each ring starts at another azimuth than ±π.
Scan ringByRing(const Scan& organised, int first_column) {
  Scan scan = organised;
  std::vector<std::uint32_t> order(scan.cloud.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  const auto turned = [&](std::uint32_t i) {
    return (organised.cloud.column[i] + organised.cloud.columns - first_column) %
           organised.cloud.columns;
  };
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(organised.cloud.row[a], turned(a)) <
           std::pair(organised.cloud.row[b], turned(b));
  });
  for (std::size_t i = 0; i < order.size(); ++i)
    scan.cloud.points[i] = organised.cloud.points[order[i]];
  scan.cloud.row.clear();
  scan.cloud.column.clear();
  scan.cloud.rows = scan.cloud.columns = 0;
  return scan;
}

Scan shuffled(Scan scan) {
  std::mt19937 random(5);
  for (std::size_t i = scan.cloud.size(); i > 1; --i)
    std::swap(scan.cloud.points[i - 1], scan.cloud.points[random() % i]);
  scan.cloud.row.clear();
  scan.cloud.column.clear();
  scan.cloud.rows = scan.cloud.columns = 0;
  return scan;
}

/// The faces of the room box as seen from inside.
std::vector<Plane3> roomFaces(const test::Box& room) {
  std::vector<Plane3> faces;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const Vector3 normal = -side * Vector3::Unit(axis);
      faces.push_back(room.T_world_box * Plane3{normal, room.half_size_m[axis]});
    }
  }
  return faces;
}

int countMatches(const std::vector<PlaneObservation>& planes, const Plane3& face_base) {
  return static_cast<int>(std::count_if(planes.begin(), planes.end(), [&](const auto& p) {
    return std::acos(std::min(1.0, p.patch_base.normal.dot(face_base.normal))) < kMaxAngle_rad &&
           std::abs(face_base.distance(p.patch_base.center)) < kMaxOffset_m;
  }));
}

auto pointsOn(const Scan& scan, const Plane3& face_base) {
  return std::count_if(scan.cloud.points.begin(), scan.cloud.points.end(), [&](const auto& p) {
    return std::abs(face_base.distance(scan.T_base_lidar * p.template cast<double>())) < 0.03;
  });
}

enum class Order { kOrganised, kRings, kRingsFromTheSide, kNone };

struct Case {
  const char* name;
  Order order;
  double yaw_rad;
};

Scan arranged(const Scan& organised, Order order) {
  if (order == Order::kRings) return ringByRing(organised, 0);
  if (order == Order::kRingsFromTheSide) return ringByRing(organised, 300);
  return order == Order::kNone ? shuffled(organised) : organised;
}

class RoomPlanes : public ::testing::TestWithParam<Case> {};

TEST_P(RoomPlanes, AreFoundOnceWhateverTheOrderAndTheHeading) {
  const test::World world = test::furnishedRoom();
  for (const auto& [x, y] : {std::pair(-1.0, -1.0), std::pair(3.2, 0.5)}) {
    const Pose3 T_world_base = Pose3::fromYawPitchRoll(x, y, 1.1, GetParam().yaw_rad, 0.02, -0.03);
    const Scan scan = arranged(organisedSweep(world, T_world_base, {}), GetParam().order);
    const auto planes = planeExtractors().make("range_image", PlaneParams())->extract(scan);
    std::vector<Plane3> faces = roomFaces(world.boxes[0]);
    // The thin inner wall shows the face on the robot's side only.
    const double side = x < 1.5 ? -1.0 : 1.0;
    faces.push_back({side * Vector3::UnitX(), -side * (1.5 + side * 0.06)});
    for (const Plane3& face : faces) {
      if (pointsOn(scan, T_world_base.inverse() * face) < 500) continue;
      EXPECT_EQ(countMatches(planes, T_world_base.inverse() * face), 1)
          << face.normal.transpose() << " " << face.d_m << " from " << x;
    }
    for (const PlaneObservation& p : planes) {
      EXPECT_GT(p.patch_base.plane().distance(scan.T_base_lidar.t), 0.0);
      EXPECT_TRUE(std::is_sorted(p.points.begin(), p.points.end()));
      EXPECT_LT(p.rms_m, 0.02);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Orders, RoomPlanes,
    ::testing::Values(Case{"organised", Order::kOrganised, 0.3},
                      Case{"organised_at_45_degrees", Order::kOrganised, 0.785398},
                      Case{"rings", Order::kRings, 1.1},
                      Case{"rings_from_the_side", Order::kRingsFromTheSide, 0.0},
                      Case{"no_order", Order::kNone, 0.6}),
    [](const auto& test) { return test.param.name; });

TEST(RangeImage, IsFoundAgainInAListOfRings) {
  const Scan organised = organisedSweep(test::furnishedRoom(), Pose3::translation(-1, -1, 1.1), {});
  const auto truth = rangeImage(organised.cloud);
  ASSERT_TRUE(truth);
  EXPECT_TRUE(truth->wraps);
  for (const int first : {0, 300}) {
    const Scan list = ringByRing(organised, first);
    const auto image = rangeImage(list.cloud);
    ASSERT_TRUE(image) << first;
    ASSERT_EQ(image->rows, truth->rows);
    ASSERT_EQ(image->columns, truth->columns);
    int same = 0, filled = 0;
    for (int r = 0; r < image->rows; ++r) {
      for (int c = 0; c < image->columns; ++c) {
        const std::int32_t i = image->at(r, c);
        filled += i >= 0;
        // The seam may lie elsewhere: neighbours matter, not where counting begins.
        const std::int32_t j = image->at(r, (c + 1) % image->columns);
        if (i < 0 || j < 0) continue;
        const auto direction = [&](std::int32_t k) {
          return list.cloud.points[static_cast<std::size_t>(k)].normalized();
        };
        same += (direction(i) - direction(j)).norm() < 0.02F;
      }
    }
    EXPECT_GT(filled, 0.995 * image->rows * image->columns);
    EXPECT_GT(same, 0.99 * image->rows * image->columns);
  }
}

TEST(RangeImage, IsNotSeenInUnorderedPoints) {
  const Scan organised = organisedSweep(test::furnishedRoom(), Pose3::translation(-1, -1, 1.1), {});
  EXPECT_FALSE(rangeImage(shuffled(organised).cloud));
  EXPECT_FALSE(rangeImage(PointCloud()));
}

class Extractors : public ::testing::TestWithParam<std::string> {
 protected:
  std::vector<PlaneObservation> extract(const Scan& scan) const {
    return planeExtractors().make(GetParam(), PlaneParams())->extract(scan);
  }
};

TEST_P(Extractors, TheCovarianceIsThatOfTheErrors) {
  // Without the floors on the covariance, over many looks at one wall.
  PlaneParams params;
  params.min_sigma_offset_m = 1e-6;
  params.min_sigma_normal_rad = 1e-6;
  const auto extractor = planeExtractors().make(GetParam(), params);
  const test::World room = {{test::Box{Pose3::translation(0, 0, 1.5), Vector3(6, 4.5, 1.5)}}};
  test::LidarModel lidar;
  lidar.rows = 32;
  lidar.columns = 512;
  lidar.sweep_s = 0.0;
  double chi2 = 0.0;
  int n = 0;
  std::mt19937_64 random(3);
  for (int i = 0; i < 12; ++i) {
    const Pose3 T_world_base =
        Pose3::fromYawPitchRoll(-2 + 0.3 * i, 0.2 * i - 1, 1.1, 0.4 * i, 0, 0);
    const Scan scan = test::sweep(
        room, lidar, [&](double) { return T_world_base; }, 0.0, random);
    for (const PlaneObservation& p : extractor->extract(scan)) {
      for (const Plane3& face : roomFaces(room.boxes[0])) {
        const Plane3 face_base = T_world_base.inverse() * face;
        if (p.patch_base.normal.dot(face_base.normal) < 0.99) continue;
        Vector3 e;
        e << sphereLog(p.patch_base.normal, face_base.normal).w,
            face_base.distance(p.patch_base.center);
        chi2 += squaredMahalanobis(e, p.covariance);
        ++n;
      }
    }
  }
  ASSERT_GE(n, 60);
  const double per_freedom = chi2 / (3.0 * n);
  EXPECT_GT(per_freedom, 0.4);
  EXPECT_LT(per_freedom, 1.8);
}

TEST_P(Extractors, WhatStandsAtAWallIsNotPartOfIt) {
  // A box of 40 cm right at the wall x = 6.
  test::World world = {{test::Box{Pose3::translation(0, 0, 1.5), Vector3(6, 4.5, 1.5)},
                        test::Box{Pose3::translation(5.8, 0, 1.2), Vector3(0.2, 0.2, 0.2)}}};
  const Pose3 T_world_base = Pose3::translation(1, 0.3, 1.0);
  const Scan scan = organisedSweep(world, T_world_base, {});
  const Pose3 T_world_lidar = T_world_base * scan.T_base_lidar;
  int on_box = 0, taken = 0;
  const auto planes = extract(scan);
  ASSERT_GE(planes.size(), 4u);
  for (std::uint32_t i = 0; i < scan.cloud.size(); ++i) {
    const Vector3 p = T_world_lidar * scan.cloud.points[i].cast<double>();
    const bool box = p.x() < 5.9 && (p - Vector3(5.8, 0, 1.2)).cwiseAbs().maxCoeff() < 0.25;
    if (!box) continue;
    ++on_box;
    for (const auto& plane : planes)
      taken += std::binary_search(plane.points.begin(), plane.points.end(), i);
  }
  EXPECT_GT(on_box, 80);
  EXPECT_LT(taken, on_box / 20);
}

TEST_P(Extractors, SmallFacesAreLeftOut) {
  test::World world = {{test::Box{Pose3::translation(3, 0, 1.0), Vector3(0.3, 0.3, 0.3)}}};
  test::LidarModel lidar;
  lidar.sweep_s = 0.0;
  std::mt19937_64 random(2);
  const Scan scan = test::sweep(
      world, lidar, [](double) { return Pose3::translation(0, 0, 0.7); }, 0.0, random);
  EXPECT_GT(scan.cloud.size(), 200u);
  EXPECT_TRUE(extract(scan).empty());
}

TEST_P(Extractors, EmptyAndTinyScansHaveNoPlanes) {
  Scan scan;
  EXPECT_TRUE(extract(scan).empty());
  for (int i = 0; i < 20; ++i)
    scan.cloud.points.emplace_back(0.1F * static_cast<float>(i), 1.0F, 0.0F);
  EXPECT_TRUE(extract(scan).empty());
  scan.cloud.points.assign(5000, Eigen::Vector3f(1, 2, 3));
  EXPECT_TRUE(extract(scan).empty());
}

TEST_P(Extractors, GiveTheSamePlanesAgain) {
  const Scan scan = organisedSweep(test::furnishedRoom(), Pose3::translation(-1, -1, 1.1), {});
  const auto a = extract(scan), b = extract(scan);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].patch_base.center, b[i].patch_base.center);
    EXPECT_EQ(a[i].covariance, b[i].covariance);
    EXPECT_EQ(a[i].points, b[i].points);
  }
}

INSTANTIATE_TEST_SUITE_P(Registry, Extractors, ::testing::ValuesIn(planeExtractors().names()),
                         [](const auto& test) { return test.param; });

TEST(PlaneExtractor, UnknownNamesAreErrors) {
  EXPECT_THROW(planeExtractors().make("hough", PlaneParams()), ConfigError);
}

}  // namespace
}  // namespace dynemo
