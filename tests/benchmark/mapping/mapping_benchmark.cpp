// Keyframe policy, graph deltas, association of planes, scan fitness and localisation from
// entities.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <random>

#include "dynemo/core/noise.h"
#include "dynemo/mapping/delta_builder.h"
#include "dynemo/mapping/keyframe_policy.h"
#include "dynemo/mapping/localize.h"
#include "dynemo/mapping/odometry_noise.h"

namespace dynemo {
namespace {

constexpr int kEntities = 10;

std::vector<EntityObservation> observations() {
  std::vector<EntityObservation> list;
  for (int i = 0; i < kEntities; ++i) {
    EntityObservation o;
    o.entity = {i};
    o.semantic_class = i % 2 ? SemanticClass::kAgent : SemanticClass::kObject;
    o.T_base_entity = Pose3::translation(2 + 0.3 * i, i % 3, 0.2);
    o.covariance = isotropicCovariance(0.01, 0.02);
    list.push_back(o);
  }
  return list;
}

/// A graph in which the same entities were seen from every keyframe.
CSceneGraph graphOf(int keyframes) {
  CSceneGraph graph;
  const EntityModels models;
  const DeltaBuilder builder(MappingParams(), models);
  for (int i = 0; i < keyframes; ++i) {
    KeyframeData data;
    data.stamp = Stamp::fromSeconds(i);
    data.T_map_base = data.T_odom_base = Pose3::translation(0.01 * i, 0, 0);
    data.odometry_covariance = isotropicCovariance(0.01, 0.01);
    data.observations = observations();
    for (auto& o : data.observations) o.stamp = data.stamp;
    graph.apply(builder.build(graph, data));
  }
  return graph;
}

/// Floor and two walls, `points` of them.
Scan room(int points) {
  Scan scan;
  scan.T_base_lidar = Pose3::translation(0, 0, 0.5);
  std::mt19937 rng(1);
  std::uniform_real_distribution<float> u(-5.0F, 5.0F);
  for (int i = 0; i < points; ++i) {
    if (i % 3 == 0) scan.cloud.points.emplace_back(u(rng), u(rng), -0.6F);
    if (i % 3 == 1) scan.cloud.points.emplace_back(5.0F, u(rng), 0.3F * u(rng));
    if (i % 3 == 2) scan.cloud.points.emplace_back(u(rng), -5.0F, 0.3F * u(rng));
  }
  return scan;
}

void KeyframeDecision(benchmark::State& state) {
  const CSceneGraph graph = graphOf(50);
  const auto seen = observations();
  KeyframePolicy policy{KeyframeParams()};
  const Pose3 T = graph.keyframes().back()->T_odom_base;
  for (auto _ : state)
    benchmark::DoNotOptimize(policy.decide({Stamp::fromSeconds(60), T, T, seen}, graph));
}
BENCHMARK(KeyframeDecision);

void BuildDelta(benchmark::State& state) {
  const CSceneGraph graph = graphOf(static_cast<int>(state.range(0)));
  const EntityModels models;
  const DeltaBuilder builder(MappingParams(), models);
  KeyframeData data;
  data.odometry_covariance = isotropicCovariance(0.01, 0.01);
  data.observations = observations();
  for (auto _ : state) benchmark::DoNotOptimize(builder.build(graph, data));
}
BENCHMARK(BuildDelta)->Arg(10)->Arg(100)->Unit(benchmark::kMicrosecond);

/// Four walls of 10 m, of which the keyframes saw all.
std::vector<PlaneObservation> walls() {
  std::vector<PlaneObservation> list;
  for (int side = 0; side < 4; ++side) {
    PlaneObservation wall;
    const Matrix3 R = expSO3(Vector3(0, 0, 0.5 * 3.14159265358979323846 * side));
    wall.patch_base.center = R * Vector3(5, 0, 1);
    wall.patch_base.normal = -R.col(0);
    for (std::int16_t i = -20; i < 20; ++i)
      for (std::int16_t j = -4; j < 6; ++j) wall.patch_base.cells.push_back({i, j});
    wall.covariance = 1e-5 * Matrix3::Identity();
    list.push_back(wall);
  }
  return list;
}

void AssociatePlanes(benchmark::State& state) {
  CSceneGraph graph;
  const EntityModels models;
  const DeltaBuilder builder(MappingParams(), models);
  KeyframeData data;
  data.odometry_covariance = isotropicCovariance(0.01, 0.01);
  data.planes = walls();
  for (int i = 0; i < static_cast<int>(state.range(0)); ++i) {
    graph.apply(builder.build(graph, data));
    data.plane_association.plane.clear();
    for (const auto& plane : graph.planes()) data.plane_association.plane.push_back(plane->id);
  }
  const PlaneAssociationParams params;
  std::size_t found = 0;
  for (auto _ : state) {
    const auto candidates = planeCandidates(graph, Pose3(), data.planes, params);
    const auto n = static_cast<Eigen::Index>(6 + 3 * candidates.size());
    const KeyframePrediction prediction(graph, Pose3(), data.odometry_covariance, candidates,
                                        1e-4 * MatrixX::Identity(n, n));
    const auto result = associatePlanes(graph, prediction, data.planes, params);
    found = static_cast<std::size_t>(std::count_if(result.plane.begin(), result.plane.end(),
                                                   [](const auto& p) { return p.has_value(); }));
  }
  state.counters["associated"] = static_cast<double>(found);
}
BENCHMARK(AssociatePlanes)->Arg(10)->Arg(1000)->Unit(benchmark::kMicrosecond);

void ScanFitness(benchmark::State& state) {
  const Scan scan = room(static_cast<int>(state.range(0)));
  for (auto _ : state)
    benchmark::DoNotOptimize(scanFitness(scan, scan, Pose3::translation(0.05, 0, 0)));
}
BENCHMARK(ScanFitness)->Arg(16384)->Unit(benchmark::kMillisecond);

void LocalizeFromEntities(benchmark::State& state) {
  const CSceneGraph graph = graphOf(5);
  const auto seen = observations();
  for (auto _ : state) benchmark::DoNotOptimize(localizeFromEntities(seen, graph));
}
BENCHMARK(LocalizeFromEntities)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace dynemo
