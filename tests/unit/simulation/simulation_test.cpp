// Whole datasets: what is in the files, and that the same world gives the same bytes.
#include "dynemo/simulation/simulation.h"

#include <gtest/gtest.h>
#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/maps/CPointsMap.h>
#include <mrpt/maps/registerAllClasses.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CObservationRotatingScan.h>
#include <mrpt/obs/registerAllClasses.h>
#include <mrpt/serialization/CArchive.h>

#include <map>

#include "dynemo/core/error.h"
#include "dynemo/core/mrpt_conversions.h"
#include "dynemo/evaluation/entity_data.h"
#include "dynemo/evaluation/trajectory.h"
#include "dynemo/perception/entity_model.h"
#include "dynemo/simulation/scene.h"
#include "dynemo/simulation/world_file.h"
#include "small_world.h"

namespace dynemo::simulation::test {
namespace {

namespace fs = std::filesystem;

bool onwards(double) { return true; }

std::vector<mrpt::obs::CObservation::Ptr> readRawlog(const fs::path& file) {
  mrpt::obs::registerAllClasses_mrpt_obs();
  mrpt::maps::registerAllClasses_mrpt_maps();
  mrpt::io::CFileGZInputStream in(file.string());
  auto archive = mrpt::serialization::archiveFrom(in);
  std::vector<mrpt::obs::CObservation::Ptr> all;
  try {
    while (true) all.push_back(archive.ReadObject<mrpt::obs::CObservation>());
  } catch (const mrpt::serialization::CExceptionEOF&) {
  }
  return all;
}

std::map<std::string, std::string> filesOf(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file())
      files[fs::relative(entry.path(), folder)] = readBytes(entry.path());
  return files;
}

TEST(Simulation, SameWorldSameBytesWhateverTheThreads) {
  TemporaryFolder one, two, other;
  simulate(smallWorld(), one.path(), 1, onwards);
  simulate(smallWorld(), two.path(), 3, onwards);
  const auto first = filesOf(one.path());
  EXPECT_EQ(first, filesOf(two.path()));
  World differently = smallWorld();
  differently.seed = 4;
  simulate(differently, other.path(), 2, onwards);
  EXPECT_NE(readBytes(one.path() / "small.rawlog"), readBytes(other.path() / "small.rawlog"));
}

TEST(Simulation, TheWrittenWorldRepeatsTheDataset) {
  TemporaryFolder one, two;
  simulate(smallWorld(), one.path(), 2, onwards);
  simulate(readWorld(one.path() / "small_world.yaml"), two.path(), 2, onwards);
  EXPECT_EQ(filesOf(one.path()), filesOf(two.path()));
}

TEST(Simulation, RecordsEverySensorInTheOrderOfTime) {
  TemporaryFolder folder;
  const World world = smallWorld();
  const auto counts = simulate(world, folder.path(), 2, onwards);
  std::map<std::string, std::size_t> found;
  Stamp last;
  for (const auto& o : readRawlog(folder.path() / "small.rawlog")) {
    ++found[o->sensorLabel];
    EXPECT_GE(fromMrpt(o->timestamp), last);
    last = fromMrpt(o->timestamp);
    if (const auto image = std::dynamic_pointer_cast<mrpt::obs::CObservationImage>(o)) {
      EXPECT_TRUE(
          fs::exists(folder.path() / "small_Images" / image->image.getExternalStorageFile()));
    }
    mrpt::poses::CPose3D pose;
    o->getSensorPose(pose);
    const Pose3 T_base_sensor = fromMrpt(pose);
    if (o->sensorLabel == "lidar") {
      EXPECT_LT(local(T_base_sensor, T_base_lidar(world.sensors.lidar)).norm(), 1e-6);
    } else if (o->sensorLabel == "camera") {
      EXPECT_LT(local(T_base_sensor, T_base_camera(world.sensors.camera)).norm(), 1e-6);
    }
  }
  const std::map<std::string, std::size_t> expected{
      {"camera", 21}, {"lidar", 21}, {"odom2d", 81}, {"odom3d", 81}};
  EXPECT_EQ(found, expected);
  EXPECT_EQ(counts.scans, 21u);
  EXPECT_EQ(counts.images, 21u);
  EXPECT_GT(counts.points, 21u * 3000);
}

TEST(Simulation, TruthFilesAreReadByTheEvaluation) {
  TemporaryFolder folder;
  const World world = smallWorld();
  simulate(world, folder.path(), 2, onwards);
  const Trajectory robot = readTum(folder.path() / "small_gt_robot.tum");
  const RobotMotion motion(world.robot, world.seed);
  EXPECT_EQ(robot.size(), 401u) << "every 10 ms; the sensors' stamps are among them";
  for (const auto& pose : robot) {
    const double t_s = secondsBetween(robot.front().stamp, pose.stamp);
    EXPECT_LT(local(motion.at(t_s), pose.T).norm(), 1e-6);
  }
  const Scene scene(world);
  for (const auto& [id, truth] : readEntityTruths(folder.path() / "small_gt_entities.csv")) {
    for (std::size_t i = 0; i < world.entities.size(); ++i) {
      if (world.entities[i].id != id.value) continue;
      for (const auto& pose : truth.poses) {
        const double t_s = secondsBetween(robot.front().stamp, pose.stamp);
        EXPECT_LT(local(scene.entities()[i].at(t_s), pose.T).norm(), 1e-5) << id << " at " << t_s;
      }
      EXPECT_GE(secondsBetween(robot.front().stamp, truth.poses.back().stamp), 4.0 - 1e-6);
    }
  }
  EXPECT_EQ(EntityModels::load(folder.path() / "small_entities.yaml").all().size(), 3u);
}

/// The rows of an object that is carried away at once are a microsecond apart.
TEST(Simulation, ObjectsJumpBetweenTwoRows) {
  TemporaryFolder folder;
  simulate(smallWorld(), folder.path(), 2, onwards);
  const auto truths = readEntityTruths(folder.path() / "small_gt_entities.csv");
  const auto& poses = truths.at(EntityId{1}).poses;
  ASSERT_EQ(poses.size(), 4u);
  EXPECT_NEAR(secondsBetween(poses[1].stamp, poses[2].stamp), 1e-6, 1e-9);
  EXPECT_NEAR((poses[2].T.t - poses[1].T.t).norm(), (Vector2(4.2, 0.8) - Vector2(3.5, 1.0)).norm(),
              1e-6);
}

TEST(Simulation, RotatingScanHoldsTheSamePointsAndTheirTimes) {
  TemporaryFolder cloud_folder, image_folder;
  World world = smallWorld();
  world.duration_s = 0.5;
  world.sensors.noise = false;
  world.sensors.lidar.motion_distortion = true;
  simulate(world, cloud_folder.path(), 2, onwards);
  world.sensors.lidar.rotating_scan = true;
  simulate(world, image_folder.path(), 2, onwards);
  const auto clouds = readRawlog(cloud_folder.path() / "small.rawlog");
  const auto images = readRawlog(image_folder.path() / "small.rawlog");
  ASSERT_EQ(clouds.size(), images.size());
  for (std::size_t i = 0; i < clouds.size(); ++i) {
    const auto scan = std::dynamic_pointer_cast<mrpt::obs::CObservationRotatingScan>(images[i]);
    if (!scan) continue;
    const auto cloud = std::dynamic_pointer_cast<mrpt::obs::CObservationPointCloud>(clouds[i]);
    EXPECT_EQ(scan->sweepDuration, 1.0 / world.sensors.lidar.rate_hz);
    std::size_t k = 0;
    for (int row = 0; row < scan->rangeImage.rows(); ++row) {
      for (int column = 0; column < scan->rangeImage.cols(); ++column) {
        if (scan->rangeImage(row, column) == 0) continue;
        const double range_m = scan->rangeImage(row, column) * scan->rangeResolution;
        const double elevation = world.sensors.lidar.elevation_rad(row);
        const double azimuth = scan->startAzimuth + scan->azimuthSpan * column / scan->columnCount;
        float x, y, z;
        cloud->pointcloud->getPoint(k++, x, y, z);
        EXPECT_NEAR(x, range_m * std::cos(elevation) * std::cos(azimuth), 2e-3);
        EXPECT_NEAR(y, range_m * std::cos(elevation) * std::sin(azimuth), 2e-3);
        EXPECT_NEAR(z, range_m * std::sin(elevation), 2e-3);
      }
    }
    EXPECT_EQ(k, cloud->pointcloud->size());
  }
}

TEST(Simulation, StopsWhenAskedToAndLeavesAShorterDataset) {
  TemporaryFolder folder;
  simulate(smallWorld(), folder.path(), 2, [](double t_s) { return t_s < 1.0; });
  const auto all = readRawlog(folder.path() / "small.rawlog");
  ASSERT_FALSE(all.empty());
  EXPECT_LT(secondsBetween(fromMrpt(all.front()->timestamp), fromMrpt(all.back()->timestamp)), 1.0);
}

TEST(Simulation, AFileInTheWayIsADataError) {
  TemporaryFolder folder;
  fs::create_directories(folder.path() / "small.rawlog.part");
  EXPECT_THROW(simulate(smallWorld(), folder.path(), 1, onwards), DataError);
  EXPECT_FALSE(fs::exists(folder.path() / "small.rawlog"));
}

}  // namespace
}  // namespace dynemo::simulation::test
