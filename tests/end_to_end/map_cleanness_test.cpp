// Whether the exported map holds the place and not those who move in it, by the ground truth.
#include <gtest/gtest.h>

#include <cstring>
#include <set>

#include "dynemo/evaluation/entity_data.h"
#include "dynemo/graph/session.h"
#include "slam_run.h"

namespace dynemo::test {
namespace {

/// The structure's points of map.ply, as the bytes of their coordinates.
std::set<std::string> structureOf(const std::string& ply) {
  constexpr std::size_t kPosition = 3 * sizeof(float), kPoint = kPosition + 3 + 1 + 4;
  const std::string end = "end_header\n";
  std::set<std::string> points;
  for (std::size_t at = ply.find(end) + end.size(); at + kPoint <= ply.size(); at += kPoint)
    if (ply[at + kPosition + 3] == 0) points.insert(ply.substr(at, kPosition));
  return points;
}

/// Well inside of what the simulator's people and boxes fill.
bool inside(const Vector3& p_entity, SemanticClass semantic_class) {
  const Vector3 p = p_entity.cwiseAbs();
  if (semantic_class == SemanticClass::kAgent)
    return p.head<2>().norm() < 0.28 && p_entity.z() > -0.93 && p_entity.z() < 0.8;
  return p.x() < 0.32 && p.y() < 0.32 && p_entity.z() > -0.15 && p.z() < 0.32;
}

/// Further from it than any noise.
bool near(const Vector3& p_entity) {
  return p_entity.head<2>().norm() < 0.6 && std::abs(p_entity.z()) < 1.1;
}

struct Cleanness {
  std::size_t moving = 0;     ///< points of entities that the map calls structure
  std::size_t structure = 0;  ///< points of the place
  std::size_t lost = 0;       ///< of these, those that the map has not
};

/// Judges each point of each scan where it really was when it was taken.
Cleanness judge(const fs::path& run, const Arguments& settings) {
  const TemporaryFolder folder;
  Arguments command = {DYNEMO_EXPORT,      run,     "--format",       "ply", "--output",
                       folder / "map.ply", "--set", "cloud.voxel_m=0"};
  command.insert(command.end(), settings.begin(), settings.end());
  const Outcome outcome = runCommand(command);
  EXPECT_EQ(outcome.status, 0) << describe(outcome);
  const auto map = structureOf(readBytes(folder / "map.ply"));

  const Dataset dataset = bundledSample();
  const EntityTruths truths = readEntityTruths(dataset.entityTruth());
  const Trajectory robot = readTum(dataset.truth());
  const Session session = loadRunSession(run);
  Cleanness clean;
  for (const auto& keyframe : session.graph.keyframes()) {
    const auto T_world_base = poseAt(robot, keyframe->scan->stamp);
    if (!T_world_base) continue;
    const Pose3 T_map_lidar = keyframe->T_map_base() * keyframe->scan->T_base_lidar;
    const Pose3 T_world_lidar = *T_world_base * keyframe->scan->T_base_lidar;
    std::vector<std::pair<Pose3, SemanticClass>> entities;
    for (const auto& [id, truth] : truths) {
      if (const auto T = poseAt(truth.poses, keyframe->scan->stamp))
        entities.emplace_back(T->inverse() * T_world_lidar, truth.semantic_class);
    }
    for (const Eigen::Vector3f& p : keyframe->scan->cloud.points) {
      const Eigen::Vector3f p_map = (T_map_lidar * p.cast<double>()).cast<float>();
      std::string bytes(3 * sizeof(float), '\0');
      std::memcpy(bytes.data(), p_map.data(), bytes.size());
      const bool in_map = map.contains(bytes);
      bool is_inside = false, is_near = false;
      for (const auto& [T_entity_lidar, semantic_class] : entities) {
        const Vector3 p_entity = T_entity_lidar * p.cast<double>();
        is_inside |= inside(p_entity, semantic_class);
        is_near |= near(p_entity);
      }
      clean.moving += is_inside && in_map;
      clean.structure += !is_near;
      clean.lost += !is_near && !in_map;
    }
  }
  return clean;
}

TEST(MapCleanness, PeopleAndCarriedBoxesLeaveNoTraceAndThePlaceStays) {
  const fs::path run = bundledRun("full").folder();
  const Cleanness fragments_only =
      judge(run, {"--set", "structure.volumes=false", "--set", "structure.seen_through=false"});
  const Cleanness clean = judge(run, {});
  std::cout << "points of entities in the structure: " << clean.moving << ", with fragments alone "
            << fragments_only.moving << "; of the place lost: " << clean.lost << " of "
            << clean.structure << '\n';
  EXPECT_GT(fragments_only.moving, 50'000u);
  EXPECT_LT(static_cast<double>(clean.moving), 0.03 * static_cast<double>(fragments_only.moving));
  EXPECT_GT(clean.structure, 400'000u);
  EXPECT_LT(static_cast<double>(clean.lost), 0.002 * static_cast<double>(clean.structure));
}

TEST(MapCleanness, EachOfTheTwoMeansDoesItsPart) {
  const fs::path run = bundledRun("full").folder();
  const Cleanness volumes = judge(run, {"--set", "structure.seen_through=false"});
  const Cleanness sights = judge(run, {"--set", "structure.volumes=false"});
  const Cleanness both = judge(run, {});
  EXPECT_LT(both.moving, volumes.moving / 4);
  EXPECT_LT(both.moving, sights.moving / 2);
}

}  // namespace
}  // namespace dynemo::test
