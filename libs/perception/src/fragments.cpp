#include "dynemo/perception/fragments.h"

#include <algorithm>
#include <cmath>

#include "euclidean_clusters.h"
#include "local_planes.h"

namespace dynemo {
namespace {

using Eigen::Vector3f;

/// Highest point of an entity over its origin that is looked at [m].
constexpr float kMaxAboveOrigin_m = 1.5F;
/// Furthest that the ground may lie below an origin [m].
constexpr float kMaxBelowOrigin_m = 2.0F;
/// Walls are told from faces of the entity in a region wider by this factor.
constexpr float kWallRegionFactor = 1.5F;

/// The points around one entity, in a frame at its origin with z up.
struct Region {
  PointIndices index;
  std::vector<Vector3f> points;
};

Pose3 localFrame(const Scan& scan, const EntityObservation& observation, const Vector3& up_base) {
  const Matrix3 R_local_base =
      Eigen::Quaterniond::FromTwoVectors(up_base, Vector3::UnitZ()).toRotationMatrix();
  const Pose3 T_local_base(R_local_base, -(R_local_base * observation.T_base_entity.t));
  return T_local_base * scan.T_base_lidar;
}

Region cutRegion(const PointCloud& cloud, const Pose3& T_local_lidar, double radius_m) {
  const Eigen::Matrix3f R = T_local_lidar.R.cast<float>();
  const Vector3f t = T_local_lidar.t.cast<float>();
  const float radius2 = static_cast<float>(radius_m * radius_m);
  Region region;
  for (std::uint32_t i = 0; i < cloud.points.size(); ++i) {
    const Vector3f p = R * cloud.points[i] + t;
    if (p.head<2>().squaredNorm() > radius2) continue;
    if (p.z() > kMaxAboveOrigin_m || p.z() < -kMaxBelowOrigin_m) continue;
    region.index.push_back(i);
    region.points.push_back(p);
  }
  return region;
}

std::optional<double> originHeight_m(const FragmentContext& context, EntityId entity) {
  const EntityModel* model = context.models ? context.models->findEntity(entity) : nullptr;
  return model ? model->origin_height_m : std::nullopt;
}

/// The region without ground, walls, and what is further away than `radius_m`.
Region foreground(const Region& region, std::optional<double> origin_height_m, double radius_m,
                  const FragmentParams& params) {
  std::optional<double> ground_height_m;
  if (origin_height_m) ground_height_m = -*origin_height_m;
  const LocalPlane ground = findGround(region.points, ground_height_m, params);
  std::vector<char> keep(region.points.size(), 1);
  for (std::size_t i = 0; i < keep.size(); ++i) {
    keep[i] = ground.distance(region.points[i]) > static_cast<float>(params.ground_tolerance_m);
  }
  dropWalls(region.points, ground.normal, params, keep);
  const float radius2 = static_cast<float>(radius_m * radius_m);
  Region rest;
  for (std::size_t i = 0; i < keep.size(); ++i) {
    if (!keep[i] || region.points[i].head<2>().squaredNorm() > radius2) continue;
    rest.index.push_back(region.index[i]);
    rest.points.push_back(region.points[i]);
  }
  return rest;
}

float distanceToOrigin_m(const Region& region, const PointIndices& cluster) {
  float nearest = std::numeric_limits<float>::infinity();
  for (const std::uint32_t i : cluster) nearest = std::min(nearest, region.points[i].norm());
  return nearest;
}

PointIndices scanIndices(const Region& region, const PointIndices& cluster) {
  PointIndices indices;
  for (const std::uint32_t i : cluster) indices.push_back(region.index[i]);
  return indices;
}

bool sizeAllowed(const PointIndices& cluster, const FragmentParams& params) {
  return static_cast<int>(cluster.size()) >= params.min_points &&
         static_cast<int>(cluster.size()) <= params.max_points;
}

PointIndices nearestCluster(const Region& region, const FragmentParams& params) {
  PointIndices best;
  auto best_distance = static_cast<float>(params.max_tag_distance_m);
  for (const PointIndices& cluster :
       euclideanClusters(region.points, static_cast<float>(params.cluster_tolerance_m))) {
    if (!sizeAllowed(cluster, params)) continue;
    const float distance = distanceToOrigin_m(region, cluster);
    if (distance > best_distance) continue;
    best = cluster;
    best_distance = distance;
  }
  return scanIndices(region, best);
}

/// Limbs may be separate clusters: all of the cylinder, as long as it is enough.
PointIndices wholeCylinder(const Region& region, const FragmentParams& params) {
  return static_cast<int>(region.index.size()) >= params.min_points ? region.index : PointIndices{};
}

PointIndices extractFragment(const Scan& scan, const EntityObservation& observation,
                             const FragmentParams& params, const FragmentContext& context) {
  const bool agent = observation.semantic_class == SemanticClass::kAgent;
  const Region region = cutRegion(scan.cloud, localFrame(scan, observation, context.up_base),
                                  params.region_radius_m * static_cast<double>(kWallRegionFactor));
  const Region rest = foreground(region, originHeight_m(context, observation.entity),
                                 agent ? params.agent_radius_m : params.region_radius_m, params);
  return agent ? wholeCylinder(rest, params) : nearestCluster(rest, params);
}

}  // namespace

void fields(FieldVisitor& v, FragmentParams& p) {
  v.number("cluster_tolerance_m", p.cluster_tolerance_m, "Gap that separates two clusters",
           Range::positive());
  v.integer("min_points", p.min_points, "Least points of a fragment", {1.0, 1e9});
  v.integer("max_points", p.max_points, "Most points of an object's fragment", {1.0, 1e9});
  v.number("max_tag_distance_m", p.max_tag_distance_m,
           "Largest distance from an object's origin to its cluster", Range::positive());
  v.number("agent_radius_m", p.agent_radius_m, "Radius of the upright cylinder around an agent",
           Range::positive());
  v.number("region_radius_m", p.region_radius_m, "Only this far around an object is looked at",
           Range::positive());
  v.number("ground_tolerance_m", p.ground_tolerance_m,
           "Points this close over the ground are left out", Range::positive());
  v.number("plane_tolerance_m", p.plane_tolerance_m, "Points this close to a wall are left out",
           Range::positive());
  v.number("plane_min_length_m", p.plane_min_length_m,
           "Upright planes at least this long count as walls", Range::positive());
}

std::vector<PointIndices> extractFragments(const Scan& scan,
                                           const std::vector<EntityObservation>& observations,
                                           const FragmentParams& params,
                                           const FragmentContext& context) {
  std::vector<PointIndices> fragments;
  for (const EntityObservation& observation : observations) {
    fragments.push_back(extractFragment(scan, observation, params, context));
  }
  return fragments;
}

}  // namespace dynemo
