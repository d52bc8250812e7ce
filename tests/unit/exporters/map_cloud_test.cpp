// The map cloud, read back from ply and pcd by parsers of the test's own.
#include "map_cloud.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <set>
#include <sstream>
#include <tuple>

#include "small_run.h"

namespace dynemo::test {
namespace {

struct ReadPoint {
  float x, y, z;
  std::uint32_t rgb;
  int semantic_class, entity;
};

template <class T>
T take(const std::string& bytes, std::size_t& at) {
  T value;
  EXPECT_LE(at + sizeof(T), bytes.size());
  std::memcpy(&value, bytes.data() + at, sizeof(T));
  at += sizeof(T);
  return value;
}

/// Header lines up to and with the last one; `at` is where the data begins.
std::vector<std::string> header(const std::string& bytes, const std::string& last,
                                std::size_t& at) {
  std::vector<std::string> lines;
  std::istringstream in(bytes);
  for (std::string line; std::getline(in, line);) {
    lines.push_back(line);
    if (line == last) break;
  }
  at = static_cast<std::size_t>(in.tellg());
  return lines;
}

std::size_t countIn(const std::vector<std::string>& lines, const std::string& key) {
  for (const std::string& line : lines) {
    if (line.starts_with(key)) return std::stoul(line.substr(key.size()));
  }
  ADD_FAILURE() << "no line starts with " << key;
  return 0;
}

std::vector<ReadPoint> readPly(const std::string& bytes) {
  std::size_t at = 0;
  const auto lines = header(bytes, "end_header", at);
  std::vector<ReadPoint> points(countIn(lines, "element vertex "));
  for (ReadPoint& p : points) {
    for (float* c : {&p.x, &p.y, &p.z}) *c = take<float>(bytes, at);
    p.rgb = 0;
    for (int i = 0; i < 3; ++i) p.rgb = p.rgb << 8u | take<std::uint8_t>(bytes, at);
    p.semantic_class = take<std::uint8_t>(bytes, at);
    p.entity = take<std::int32_t>(bytes, at);
  }
  EXPECT_EQ(at, bytes.size());
  return points;
}

std::vector<ReadPoint> readPcd(const std::string& bytes) {
  std::size_t at = 0;
  const auto lines = header(bytes, "DATA binary", at);
  std::vector<ReadPoint> points(countIn(lines, "POINTS "));
  EXPECT_EQ(countIn(lines, "WIDTH "), points.size());
  for (ReadPoint& p : points) {
    for (float* c : {&p.x, &p.y, &p.z}) *c = take<float>(bytes, at);
    p.rgb = take<std::uint32_t>(bytes, at);
    p.semantic_class = static_cast<int>(take<std::uint32_t>(bytes, at));
    p.entity = take<std::int32_t>(bytes, at);
  }
  EXPECT_EQ(at, bytes.size());
  return points;
}

ExportParams allPoints() {
  ExportParams params;
  params.cloud.voxel_m = 0.0;
  return params;
}

TEST(MapCloud, PlyAndPcdHoldTheSamePoints) {
  const SmallRun run = smallRun();
  const auto ply = readPly(exported("ply", run.result(), allPoints()));
  const auto pcd = readPcd(exported("pcd", run.result(), allPoints()));
  ASSERT_EQ(ply.size(), pcd.size());
  for (std::size_t i = 0; i < ply.size(); ++i) {
    EXPECT_EQ(std::tie(ply[i].x, ply[i].y, ply[i].z, ply[i].rgb, ply[i].entity),
              std::tie(pcd[i].x, pcd[i].y, pcd[i].z, pcd[i].rgb, pcd[i].entity));
    EXPECT_EQ(ply[i].semantic_class, pcd[i].semantic_class);
  }
}

TEST(MapCloud, StructureIsEveryPointThatBelongsToNoEntity) {
  const SmallRun run = smallRun();
  const auto points = readPly(exported("ply", run.result(), allPoints()));
  // Three scans of 50 points, of which six belong to the box; the box has its six where it is.
  EXPECT_EQ(points.size(), 150u);
  std::size_t structure = 0;
  for (const ReadPoint& p : points) {
    structure += p.semantic_class == 0;
    EXPECT_EQ(p.semantic_class == 0, p.entity == -1);
    EXPECT_EQ(p.rgb, pointClassColor(static_cast<PointClass>(p.semantic_class)));
  }
  EXPECT_EQ(structure, 144u);
}

/// Mean of the box's points, in a cloud of some time.
Eigen::Vector3f boxCenter(const SmallRun& run, const ExportParams& params) {
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  int count = 0;
  for (const ReadPoint& p : readPly(exported("ply", run.result(), params))) {
    if (p.entity != 7) continue;
    sum += Eigen::Vector3f(p.x, p.y, p.z);
    ++count;
  }
  return count ? Eigen::Vector3f(sum / static_cast<float>(count)) : sum;
}

TEST(MapCloud, AMovedObjectStandsWhereItWasAtTheTime) {
  const SmallRun run = smallRun();
  ExportParams params = allPoints();
  const Eigen::Vector3f at_the_end = boxCenter(run, params);
  params.cloud.at_s = 0.0;
  const Eigen::Vector3f at_the_start = boxCenter(run, params);
  const Vector3 step = run.graph.getNode<CNodePose>({6}).T_map_node.t -
                       run.graph.getNode<CNodePose>({3}).T_map_node.t;
  // The run's last frame is half-way between the two observations.
  EXPECT_GT(step.norm(), 1.0);
  params.cloud.at_s = 0.4;
  const Eigen::Vector3f later = boxCenter(run, params);
  EXPECT_LT(((later - at_the_start).cast<double>() - step).norm(), 1e-5);
  EXPECT_LE((at_the_end - at_the_start).norm(), (later - at_the_start).norm() + 1e-5f);
}

TEST(MapCloud, CanLeaveEntitiesOut) {
  const SmallRun run = smallRun();
  ExportParams params = allPoints();
  for (const EntityPoints without : {EntityPoints::kUnmoved, EntityPoints::kNone}) {
    params.cloud.entities = without;
    EXPECT_EQ(readPly(exported("ply", run.result(), params)).size(), 144u);
  }
}

TEST(MapCloud, ExportersOfARunShareWhoseThePointsAre) {
  const SmallRun run = smallRun();
  const RunResult result = run.result(), copy = result;
  StructureParams params;
  const PointOwners* first = &pointOwners(result, params, {});
  EXPECT_EQ(first, &pointOwners(copy, params, {}));
  const auto& last = *run.graph.keyframes().back();
  EXPECT_EQ(first->of(last).entity(10)->entity, EntityId{7});
  // Its own for another question.
  params.margin_m = 0.2;
  pointOwners(result, params, {});
  EXPECT_EQ(result.findings->structure, params);
}

TEST(MapCloud, HasOnePointPerVoxel) {
  const SmallRun run = smallRun();
  ExportParams params;
  params.cloud.voxel_m = 0.5;
  std::set<std::array<int, 3>> voxels;
  const auto points = readPly(exported("ply", run.result(), params));
  for (const ReadPoint& p : points) {
    const auto index = [](float c) { return static_cast<int>(std::floor(c / 0.5f)); };
    EXPECT_TRUE(voxels.insert({index(p.x), index(p.y), index(p.z)}).second);
  }
  EXPECT_GT(points.size(), 3u);
  EXPECT_LT(points.size(), 60u);
}

}  // namespace
}  // namespace dynemo::test
