#include "small_run.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <iterator>
#include <random>
#include <set>

#include "dynemo/exporters/exporter.h"
#include "dynemo/graph/edge_floor_entity.h"
#include "dynemo/graph/edge_prior.h"
#include "dynemo/graph/edge_relative_pose.h"

namespace dynemo::test {
namespace {

constexpr std::int64_t kStart_ns = 1'700'000'030'123'456'789;
constexpr double kHalfPi = 1.5707963267948966;

Stamp stampAt(double seconds) {
  return {kStart_ns + static_cast<std::int64_t>(seconds * 1'000'000'000)};
}

std::shared_ptr<const Scan> wallScan() {
  auto scan = std::make_shared<Scan>();
  scan->T_base_lidar = Pose3::translation(0.0, 0.0, 0.5);
  for (int i = 0; i < 50; ++i) {
    scan->cloud.points.emplace_back(2.0f, -1.0f + 0.04f * static_cast<float>(i), 0.0f);
  }
  return scan;
}

std::shared_ptr<CNodeKeyframe> keyframe(std::uint64_t id, double seconds, const Pose3& T_map_base,
                                        const Pose3& T_odom_base) {
  auto node = std::make_shared<CNodeKeyframe>();
  node->id = {id};
  node->stamp = stampAt(seconds);
  node->T_map_node = T_map_base;
  node->T_map_node_first = node->T_odom_base = T_odom_base;
  node->scan = wallScan();
  return node;
}

std::shared_ptr<CNodeEntity> entity(std::uint64_t id, std::int64_t entity_id, std::uint64_t kf,
                                    double seconds, const Pose3& T_map_entity) {
  auto node = std::make_shared<CNodeEntity>();
  node->id = {id};
  node->entity = {entity_id};
  node->keyframe = {kf};
  node->stamp = stampAt(seconds);
  node->T_map_node = T_map_entity;
  node->T_map_node_first = Pose3::translation(0.5, 0.25, 0.0) * T_map_entity;
  return node;
}

template <class Edge>
std::shared_ptr<Edge> edge(std::uint64_t id, std::uint64_t from, std::uint64_t to,
                           const CSceneGraph& graph, std::mt19937_64& rng) {
  auto e = std::make_shared<Edge>();
  e->id = {id};
  e->nodes = {{from}, {to}};
  const auto& a = graph.getNode<CNodePose>({from});
  const auto& b = graph.getNode<CNodePose>({to});
  // A residual small enough that the formats' rotation errors agree with ours to second order.
  const Vector6 residual = 1e-3 * (Vector6() << 1, -2, 3, 4, -5, 6).finished();
  e->T_1_2 = (a.T_map_node.inverse() * b.T_map_node).retract(residual);
  e->setInformation(randomInformation(6, rng));
  return e;
}

void addNodes(CSceneGraph& graph) {
  GraphDelta delta;
  const Pose3 T_second = Pose3::fromYawPitchRoll(1.0, 0.5, 0.0, kHalfPi, 0.0, 0.0);
  delta.nodes = {
      keyframe(0, 0.0, Pose3(), Pose3()),
      keyframe(1, 0.2, T_second, Pose3::translation(1.0, 0.625, 0.0)),
      std::make_shared<CNodeFloor>(),
      entity(3, 7, 0, 0.0, Pose3::translation(2.0, 0.0, 0.25)),
      entity(4, 101, 1, 0.2, Pose3::fromYawPitchRoll(1.0, 3.0, 1.0, -kHalfPi, 0.0, 0.0)),
      keyframe(5, 0.4, Pose3::fromYawPitchRoll(1.0, 2.0, 0.125, kHalfPi, 0.25, -0.125),
               Pose3::translation(2.0, 0.625, 0.0)),
      entity(6, 7, 5, 0.4, Pose3::translation(1.5, 4.0, 0.25)),
  };
  delta.nodes[2]->id = {2};
  graph.apply(delta);
  auto& box = const_cast<CNodeEntity&>(graph.getNode<CNodeEntity>({3}));
  box.name = "box, \"red\"";
  box.fragment = {1, 2, 3};
  auto& moved = const_cast<CNodeEntity&>(graph.getNode<CNodeEntity>({6}));
  moved.name = box.name;
  moved.moved = true;
  moved.fragment = {10, 11, 12};
  auto& walker = const_cast<CNodeEntity&>(graph.getNode<CNodeEntity>({4}));
  walker.name = "walker";
  walker.semantic_class = SemanticClass::kAgent;
}

void addEdges(CSceneGraph& graph) {
  std::mt19937_64 rng(3);
  GraphDelta delta;
  auto prior = std::make_shared<CEdgePosePrior>();
  prior->id = {0};
  prior->nodes = {{0}};
  prior->setInformation(Matrix6::Identity());
  auto height = std::make_shared<CEdgeFloorEntity>();
  height->id = {1};
  height->nodes = {{2}, {3}};
  height->setInformation(Eigen::Matrix<double, 1, 1>(400.0));
  delta.edges = {prior,
                 height,
                 edge<CEdgeOdometry>(2, 0, 1, graph, rng),
                 edge<CEdgeKeyframeEntity>(3, 0, 3, graph, rng),
                 edge<CEdgeOdometry>(4, 1, 5, graph, rng),
                 edge<CEdgeKeyframeEntity>(5, 5, 6, graph, rng),
                 edge<CEdgeIntraEntity>(6, 3, 6, graph, rng),
                 edge<CEdgeLoopClosure>(7, 1, 0, graph, rng),
                 edge<CEdgeKeyframeEntity>(8, 1, 4, graph, rng)};
  graph.apply(delta);
}

}  // namespace

SmallRun smallRun() {
  SmallRun run;
  addNodes(run.graph);
  addEdges(run.graph);
  run.frames = {
      {stampAt(0.0), Pose3(), Pose3()},
      {stampAt(0.1), Pose3::translation(0.5, 0.3125, 0.0), Pose3::translation(0.5, 0.25, -0.125)},
      {stampAt(0.2), Pose3::translation(1.0, 0.625, 0.0),
       Pose3::fromYawPitchRoll(1.0, 0.5, 0.0, kHalfPi, 0.0, 0.0)}};
  Matrix6 covariance = isotropicCovariance(0.125, 0.25);
  covariance(0, 4) = covariance(4, 0) = 0.0078125;
  run.covariances[{3}] = covariance;
  return run;
}

TemporaryFolder::TemporaryFolder() {
  static int count = 0;
  const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
  std::string name = std::string(info->test_suite_name()) + "-" + info->name();
  for (char& c : name) c = c == '/' ? '-' : c;
  path_ = std::filesystem::temp_directory_path() /
          ("dynemo-" + name + "-" + std::to_string(::getpid()) + "-" + std::to_string(++count));
  std::filesystem::create_directories(path_);
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::string readFile(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  EXPECT_TRUE(in) << file;
  return {std::istreambuf_iterator<char>(in), {}};
}

std::string exported(const std::string& name, const RunResult& run, const ExportParams& params) {
  const TemporaryFolder folder;
  const auto exporter = exporters().make(name, params);
  const auto file = folder.path() / exporter->fileName();
  exporter->write(run, file);
  if (!std::filesystem::is_directory(file)) return readFile(file);
  std::set<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(file)) files.insert(entry.path());
  std::string all;
  for (const auto& f : files) all += f.filename().string() + '\n' + readFile(f);
  return all;
}

}  // namespace dynemo::test
