// Without noise every point lies on a true surface through the true poses.
#include "dynemo/simulation/lidar.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "dynemo/simulation/datasets.h"
#include "small_world.h"

namespace dynemo::simulation::test {
namespace {

constexpr double kOnSurface_m = 1e-3;

/// From a point in a body's frame to its nearest face; the tags' sheets lie 1 mm before their
/// faces.
double distanceToBody(const Body& body, const Vector3& p) {
  double nearest_m = 1e9;
  for (const Box& box : body.boxes) {
    const Vector3 q = (box.T_body_box.inverse() * p).cwiseAbs() - box.half;
    const double outside_m = q.cwiseMax(0.0).norm(), inside_m = -q.maxCoeff();
    nearest_m = std::min(nearest_m, inside_m > 0 ? inside_m : outside_m);
  }
  for (const TagSheet& tag : body.tags) {
    const Vector3 q = tag.T_body_tag.inverse() * p;
    if (q.head<2>().cwiseAbs().maxCoeff() < 0.63 * tag.size_m)
      nearest_m = std::min(nearest_m, std::abs(q.z()));
  }
  return nearest_m;
}

double distanceToWorld(const Scene& scene, const Vector3& p_world, double t_s) {
  double nearest_m = distanceToBody(scene.bodies()[0], p_world);
  for (std::size_t i = 0; i < scene.entities().size() && nearest_m > kOnSurface_m; ++i) {
    const Vector3 p = scene.entities()[i].at(t_s).inverse() * p_world;
    if (p.norm() < 2.0) nearest_m = std::min(nearest_m, distanceToBody(scene.bodies()[i + 1], p));
  }
  return nearest_m;
}

struct Distances {
  std::size_t points = 0, off_surface = 0;
  double worst_m = 0.0;
};

Distances measure(const Scene& scene, double t_s, bool deskew) {
  const LidarSpec& spec = scene.world().sensors.lidar;
  const Sweep sweep = Lidar(scene).sweep(0, t_s);
  Distances result;
  for (const Eigen::Vector3f& point : sweep.points) {
    const Vector3 p = point.cast<double>();
    const double turned = (std::atan2(p.y(), p.x()) + std::numbers::pi) / (2 * std::numbers::pi);
    const double shot_s = deskew ? t_s + turned / spec.rate_hz : t_s;
    const Vector3 p_world = scene.robot().at(shot_s) * T_base_lidar(spec) * p;
    const double distance_m = distanceToWorld(scene, p_world, shot_s);
    ++result.points;
    result.off_surface += distance_m > kOnSurface_m;
    result.worst_m = std::max(result.worst_m, distance_m);
  }
  return result;
}

World quietWorld(bool motion_distortion) {
  World world = smallWorld();
  world.sensors.noise = false;
  world.sensors.lidar.motion_distortion = motion_distortion;
  return world;
}

TEST(LidarWithoutNoise, EveryPointIsOnATrueSurface) {
  const Scene scene(quietWorld(false));
  for (const double t_s : {0.0, 1.4, 2.2, 3.6}) {
    const Distances d = measure(scene, t_s, false);
    EXPECT_GT(d.points, 3900u) << "the room is closed: every ray hits something in range";
    EXPECT_LE(d.worst_m, kOnSurface_m) << "at " << t_s;
  }
}

TEST(LidarWithoutNoise, EveryDeskewedPointIsOnATrueSurface) {
  const Scene scene(quietWorld(true));
  for (const double t_s : {0.6, 1.4, 2.8}) {
    const Distances d = measure(scene, t_s, true);
    EXPECT_LE(d.worst_m, kOnSurface_m) << "at " << t_s;
  }
}

TEST(LidarWithoutNoise, UndeskewedPointsOfAMovingSensorAreOff) {
  const Scene scene(quietWorld(true));
  const Distances d = measure(scene, 1.4, false);
  EXPECT_GT(d.off_surface, d.points / 4);
}

TEST(LidarWithoutNoise, HandHeldSweepsDeskewToo) {
  DatasetOptions options;
  options.scale = Scale::kMini;
  World world = makeDataset("R-MAMO", options);
  world.sensors.noise = false;
  const Scene scene(world);
  for (const double t_s : {7.3, 31.0}) EXPECT_LE(measure(scene, t_s, true).worst_m, kOnSurface_m);
}

/// Ranges against a wall square to the sensor.
TEST(LidarNoise, HasTheGivenSpreadAndDropouts) {
  World world = smallWorld();
  world.sensors.lidar.quantum_m = 0.0;
  World quiet = world;
  quiet.sensors.noise = false;
  const Scene scene(world), truth(quiet);
  const Sweep all = Lidar(truth).sweep(0, 0.0);
  Lidar lidar(scene);
  double sum = 0.0, squares = 0.0;
  std::size_t returns = 0, kept = 0;
  constexpr int kSweeps = 12;
  for (int k = 0; k < kSweeps; ++k) {
    const Sweep noisy = lidar.sweep(static_cast<std::uint64_t>(k), 0.0);
    returns += all.points.size();
    kept += noisy.points.size();
    for (std::size_t i = 0, j = 0; i < noisy.points.size(); ++i) {
      while (all.ring[j] != noisy.ring[i] || all.column[j] != noisy.column[i]) ++j;
      const double error_m = noisy.range_m[i] - all.range_m[j];
      sum += error_m;
      squares += error_m * error_m;
    }
  }
  const auto n = static_cast<double>(kept);
  EXPECT_NEAR(sum / n, 0.0, 2e-4);
  EXPECT_NEAR(std::sqrt(squares / n), world.sensors.lidar.sigma_m, 2e-4);
  const double lost = 1.0 - n / static_cast<double>(returns);
  EXPECT_GT(lost, world.sensors.lidar.dropout);
  EXPECT_LT(lost, world.sensors.lidar.dropout + 0.05) << "grazing returns are few";
}

}  // namespace
}  // namespace dynemo::simulation::test
