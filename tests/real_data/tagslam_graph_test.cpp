// A moving camera mapping tags, each an object of its own, with no odometry at all: detections in,
// trajectory out.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "dynemo/evaluation/trajectory_error.h"
#include "dynemo/ingest/rawlog_source.h"
#include "dynemo/pipeline/slam_pipeline.h"
#include "sample_dataset.h"
#include "tagslam_dataset.h"

namespace dynemo {
namespace {

constexpr double kMaxAte_m = 0.01;

Trajectory runDetections(const test::TagslamDataset& dataset, const std::string& name) {
  const auto csv = std::filesystem::temp_directory_path() / ("dynemo_" + name + ".csv");
  const EntityModels models = dataset.tagsAsEntities();
  DynemoParams params;
  params.keyframes.robot_translation_m = 0.02;
  params.keyframes.robot_rotation_rad = 0.02;
  params.mapping.floor_entity = false;  // tags on a wall, which do not move at all
  params.mapping.motion.static_sigma_m = params.mapping.motion.static_sigma_rad = 1e-4;
  {
    std::ofstream out(csv);
    test::writeDetections(dataset, models, params.perception.tag_pose, params.perception.ambiguity,
                          out);
  }
  const auto source = makeRawlogSource(params.sensors, std::nullopt, csv);
  SlamPipeline pipeline(params, models, source->hasOdometry());
  while (auto frame = source->next()) {
    FrameTiming timing;
    pipeline.process(std::move(*frame), timing);
  }
  pipeline.finish();
  std::filesystem::remove(csv);
  Trajectory trajectory;
  for (const FramePose& frame : pipeline.frames())
    trajectory.push_back({frame.stamp, frame.T_map_base});
  return trajectory;
}

class TagslamGraph : public ::testing::TestWithParam<const char*> {};

TEST_P(TagslamGraph, TheTrajectoryIsThatOfTheReference) {
  const auto folder = test::realDataFolder();
  if (!folder) GTEST_SKIP() << "DYNEMO_REAL_DATA is not set";
  const auto dataset = test::readTagslam(*folder / "tagslam" / GetParam());
  Trajectory reference;
  for (const auto& [stamp, T_map_rig] : dataset.reference_tracks.at("cam_rig"))
    reference.push_back({stamp, T_map_rig});
  const Trajectory estimate = runDetections(dataset, GetParam());

  const auto aligned = alignTrajectories(reference, estimate);
  ASSERT_TRUE(aligned);
  const Statistics ate = absoluteTranslationError(*aligned);
  RecordProperty("ate_rmse_m", std::to_string(ate.rmse));
  std::cout << GetParam() << ": ATE " << 100 * ate.rmse << " cm over " << ate.count << " of "
            << reference.size() << " poses\n";
  EXPECT_LT(ate.rmse, kMaxAte_m);
  EXPECT_GT(ate.count, reference.size() * 9 / 10);
}

INSTANTIATE_TEST_SUITE_P(MovingCamera, TagslamGraph, testing::Values("test_16", "test_17"));

}  // namespace
}  // namespace dynemo
