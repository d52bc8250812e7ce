// Walls and floors of whole runs on the sample recordings against the true ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>

#include "dynemo/graph/edge_plane.h"
#include "dynemo/graph/seen_plane.h"
#include "dynemo/ingest/rawlog_source.h"
#include "dynemo/pipeline/slam_pipeline.h"
#include "sample_dataset.h"

namespace dynemo {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180.0;
constexpr std::size_t kMinPoints = 500;
constexpr double kOnWall_m = 0.03, kMinRecall = 0.95;
/// A mapped plane this near to a true one is meant to be it.
constexpr double kSameAngle_rad = 2.0 * kDegree, kSameOffset_m = 0.05;
constexpr double kMaxMedianAngle_rad = 0.1 * kDegree, kMaxMedianOffset_m = 0.01,
                 kMaxFloorError_m = 0.01;
/// Mean of the squared whitened residuals per degree of freedom.
constexpr double kMaxChi2 = 1.5;

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values.at(values.size() / 2);
}

class Run {
 public:
  Run(const std::filesystem::path& folder, const std::string& name, OdometrySource odometry)
      : truth_(folder, name), models_(EntityModels::load(folder / (name + "_entities.yaml"))) {
    DynemoParams params;
    params.odometry.source = odometry;
    const auto source = makeRawlogSource(params.sensors, folder / (name + ".rawlog"));
    pipeline_ = std::make_unique<SlamPipeline>(params, models_, source->hasOdometry());
    while (auto frame = source->next()) {
      FrameTiming timing;
      pipeline_->process(std::move(*frame), timing);
    }
    pipeline_->finish();
    align();
  }

  const CSceneGraph& graph() const { return pipeline_->graph(); }
  const test::SampleTruth& truth() const { return truth_; }
  const Pose3& T_world_map() const { return T_world_map_; }

  /// Most points of one keyframe on a true plane that faces it.
  std::size_t mostPoints(const test::TruePlane& wall) const {
    std::size_t most = 0;
    for (const auto& keyframe : graph().keyframes()) {
      const auto T_world_base = truth_.T_world_base(keyframe->stamp);
      if (!T_world_base || !keyframe->scan) continue;
      const Pose3 T_world_lidar = *T_world_base * keyframe->scan->T_base_lidar;
      if (wall.plane_world.distance(T_world_lidar.t) < 0.0) continue;
      const auto& points = keyframe->scan->cloud.points;
      const auto n = std::count_if(points.begin(), points.end(), [&](const auto& p) {
        return wall.contains(T_world_lidar * p.template cast<double>(), kOnWall_m);
      });
      most = std::max(most, static_cast<std::size_t>(n));
    }
    return most;
  }

 private:
  /// The rigid motion that brings the keyframes to their true positions.
  void align() {
    std::vector<Vector3> estimated, real;
    for (const auto& keyframe : graph().keyframes()) {
      const auto T_world_base = truth_.T_world_base(keyframe->stamp);
      if (!T_world_base) continue;
      estimated.push_back(keyframe->T_map_base().t);
      real.push_back(T_world_base->t);
    }
    const auto n = static_cast<Eigen::Index>(real.size());
    Eigen::Matrix3Xd a(3, n), b(3, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      a.col(i) = estimated[static_cast<std::size_t>(i)];
      b.col(i) = real[static_cast<std::size_t>(i)];
    }
    const Eigen::Matrix4d T = Eigen::umeyama(a, b, false);
    T_world_map_ = Pose3(Matrix3(T.topLeftCorner<3, 3>()), T.topRightCorner<3, 1>());
  }

  test::SampleTruth truth_;
  EntityModels models_;
  std::unique_ptr<SlamPipeline> pipeline_;
  Pose3 T_world_map_;
};

struct Comparison {
  int walls = 0, found = 0, twice = 0, unknown = 0;
  std::vector<double> angle_rad, offset_m;
};

Comparison compare(const Run& run) {
  Comparison c;
  int known = 0;
  for (const test::TruePlane& wall : run.truth().planes()) {
    if (wall.name == "floor") continue;
    int matches = 0;
    for (const auto& plane : run.graph().planes()) {
      const Plane3 world = run.T_world_map() * plane->plane_map;
      const Vector3 middle = run.T_world_map() * middleOf(seenPatch(run.graph(), *plane));
      const double angle =
          std::acos(std::clamp(world.normal.dot(wall.plane_world.normal), -1.0, 1.0));
      const double offset = std::abs(wall.plane_world.distance(middle));
      if (angle > kSameAngle_rad || offset > kSameOffset_m) continue;
      ++known;
      if (matches++ > 0) continue;
      c.angle_rad.push_back(angle);
      c.offset_m.push_back(offset);
    }
    c.twice += matches > 1 ? 1 : 0;
    if (run.mostPoints(wall) < kMinPoints) continue;
    ++c.walls;
    c.found += matches > 0 ? 1 : 0;
  }
  c.unknown = static_cast<int>(run.graph().planes().size()) - known;
  return c;
}

double chi2PerFreedom(const CSceneGraph& graph) {
  double sum = 0.0;
  int n = 0;
  for (const auto& edge : graph.edgeSlots()) {
    if (!dynamic_cast<const CEdgePlaneMeasurement*>(edge.get())) continue;
    sum += 2.0 * graph.edgeCost(*edge);
    n += 3;
  }
  return sum / n;
}

void expectTrueStructure(const std::filesystem::path& folder, const std::string& name,
                         OdometrySource odometry) {
  const Run run(folder, name, odometry);
  const Comparison c = compare(run);
  std::cout << name << ": " << c.found << " of " << c.walls << " walls with " << kMinPoints
            << " points found, " << c.twice << " twice, " << c.unknown
            << " planes on no wall; median angle " << median(c.angle_rad) / kDegree
            << " deg, offset " << 1e3 * median(c.offset_m) << " mm; chi2 per freedom "
            << chi2PerFreedom(run.graph()) << '\n';
  EXPECT_GE(c.walls, 5);
  EXPECT_GE(c.found, kMinRecall * c.walls);
  EXPECT_EQ(c.twice, 0);
  EXPECT_LE(median(c.angle_rad), kMaxMedianAngle_rad);
  EXPECT_LE(median(c.offset_m), kMaxMedianOffset_m);
  EXPECT_LE(chi2PerFreedom(run.graph()), kMaxChi2);
  ASSERT_EQ(run.graph().floors().size(), 1u);
  const double level = run.T_world_map().t.z() + run.graph().floors()[0]->level_m;
  std::cout << name << ": floor " << 1e3 * level << " mm off\n";
  EXPECT_NEAR(level, 0.0, kMaxFloorError_m);
}

class SampleStructure : public ::testing::TestWithParam<OdometrySource> {};

TEST_P(SampleStructure, IsTheTrueOne) {
  const auto folder = test::samplesFolder();
  if (!folder) GTEST_SKIP() << "set DYNEMO_SAMPLES to the folder with the samples";
  for (const std::string name : {"mini_samo", "mini_mamo"}) {
    expectTrueStructure(*folder / name, name, GetParam());
  }
}

INSTANTIATE_TEST_SUITE_P(Odometry, SampleStructure,
                         ::testing::Values(OdometrySource::kRawlog, OdometrySource::kLidar),
                         [](const auto& test) {
                           return test.param == OdometrySource::kLidar ? "lidar" : "rawlog";
                         });

}  // namespace
}  // namespace dynemo
