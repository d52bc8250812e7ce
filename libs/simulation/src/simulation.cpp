#include "dynemo/simulation/simulation.h"

#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CObservationRotatingScan.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_pipeline.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>

#include "dataset_files.h"
#include "dynemo/core/error.h"
#include "dynemo/core/mrpt_conversions.h"
#include "dynemo/core/output_file.h"
#include "dynemo/simulation/camera.h"
#include "dynemo/simulation/collisions.h"
#include "dynemo/simulation/lidar.h"
#include "dynemo/simulation/odometry.h"
#include "dynemo/simulation/scene.h"
#include "dynemo/simulation/world_file.h"
#include "recording.h"
#include "truth_files.h"

namespace dynemo::simulation {
namespace {

namespace fs = std::filesystem;

/// The readings of all sensors in the order of their times.
class Schedule {
 public:
  explicit Schedule(const World& world) : duration_us_(std::llround(world.duration_s * 1e6)) {
    const SensorSpecs& s = world.sensors;
    streams_ = {{Sensor::kOdom3d, s.odom3d.rate_hz, 0.0},
                {Sensor::kOdom2d, s.odom2d.rate_hz, 0.0},
                {Sensor::kLidar, s.lidar.rate_hz, 0.0},
                {Sensor::kCamera, s.camera.rate_hz, s.camera.delay_s}};
  }

  std::optional<Event> next() {
    Stream& first = *std::min_element(
        streams_.begin(), streams_.end(),
        [](const Stream& a, const Stream& b) { return a.nextTime_us() < b.nextTime_us(); });
    const Event event{first.sensor, first.index, first.nextTime_us()};
    if (event.t_us > duration_us_) return std::nullopt;
    ++first.index;
    return event;
  }

 private:
  struct Stream {
    Sensor sensor;
    double rate_hz, delay_s;
    std::uint64_t index = 0;
    std::int64_t nextTime_us() const {
      return std::llround((static_cast<double>(index) / rate_hz + delay_s) * 1e6);
    }
  };
  std::int64_t duration_us_;
  std::vector<Stream> streams_;
};

mrpt::Clock::time_point mrptTime(const World& world, std::int64_t t_us) {
  return toMrpt(Stamp{startStamp(world.seed).ns + t_us * 1000});
}

mrpt::obs::CObservation::Ptr pointCloud(const Sweep& sweep, const LidarSpec& spec) {
  auto o = mrpt::obs::CObservationPointCloud::Create();
  auto cloud = mrpt::maps::CSimplePointsMap::Create();
  cloud->reserve(sweep.points.size());
  for (const auto& p : sweep.points) cloud->insertPointFast(p.x(), p.y(), p.z());
  o->pointcloud = cloud;
  o->sensorPose = toMrpt(T_base_lidar(spec));
  return o;
}

mrpt::obs::CObservation::Ptr rotatingScan(const Sweep& sweep, const LidarSpec& spec) {
  auto o = mrpt::obs::CObservationRotatingScan::Create();
  o->rowCount = static_cast<std::uint16_t>(spec.rings);
  o->columnCount = static_cast<std::uint16_t>(spec.columns);
  o->rangeResolution = 0.002;
  o->minRange = spec.min_range_m;
  o->maxRange = spec.max_range_m;
  o->azimuthSpan = 2.0 * std::numbers::pi;
  o->startAzimuth = std::numbers::pi * (2.0 * spec.turned(0) - 1.0);
  o->sweepDuration = spec.motion_distortion ? 1.0 / spec.rate_hz : 0.0;
  o->has_satellite_timestamp = false;
  o->rangeImage.setZero(spec.rings, spec.columns);
  for (std::size_t i = 0; i < sweep.points.size(); ++i)
    o->rangeImage(sweep.ring[i], sweep.column[i]) =
        static_cast<std::uint16_t>(std::lround(sweep.range_m[i] / o->rangeResolution));
  o->sensorPose = toMrpt(T_base_lidar(spec));
  return o;
}

mrpt::obs::CObservation::Ptr imageObservation(const CameraSpec& spec, const std::string& file) {
  auto o = mrpt::obs::CObservationImage::Create();
  o->image.setExternalStorage(file);
  o->cameraPose = toMrpt(T_base_camera(spec));
  auto& p = o->cameraParams;
  p.ncols = static_cast<std::uint32_t>(spec.width);
  p.nrows = static_cast<std::uint32_t>(spec.height);
  p.setIntrinsicParamsFromValues(spec.fx, spec.fy, spec.cx, spec.cy);
  p.distortion = mrpt::img::DistortionModel::plumb_bob;
  for (std::size_t i = 0; i < 5; ++i) p.dist[i] = spec.distortion[i];
  return o;
}

/// Turns events into readings: odometry in the order of time, LiDAR and camera in any thread.
class Recorder {
 public:
  explicit Recorder(const Scene& scene)
      : scene_(scene),
        odom3d_(scene.world(), scene.robot()),
        odom2d_(scene.world(), scene.robot()) {}

  /// Events must come in their order.
  void readOdometry(Reading& reading) {
    const Event& e = reading.event;
    const bool wheels = scene_.world().robot.carrier == Carrier::kWheels;
    if (e.sensor == Sensor::kOdom3d) {
      const auto estimate = odom3d_.at(e.index, e.t_s());
      last_T_odom_base_ = estimate.T_odom_base;
      auto o = mrpt::obs::CObservationRobotPose::Create();
      o->pose = toMrptGaussian(estimate.T_odom_base, scene_.world().sensors.noise
                                                         ? estimate.covariance
                                                         : Matrix6(Matrix6::Zero()));
      label(*o, "odom3d", e);
      reading.observation = o;
    } else if (e.sensor == Sensor::kOdom2d) {
      auto o = mrpt::obs::CObservationOdometry::Create();
      if (wheels) {
        const Vector3 p = odom2d_.at(e.index, e.t_s());
        o->odometry = mrpt::poses::CPose2D(p.x(), p.y(), p.z());
      } else {
        o->odometry = mrpt::poses::CPose2D(toMrpt(last_T_odom_base_));
      }
      label(*o, "odom2d", e);
      reading.observation = o;
    }
  }

  void readSensor(Reading& reading) {
    const Event& e = reading.event;
    if (e.sensor == Sensor::kLidar) {
      const Sweep sweep = lidars_.local().sweep(e.index, e.t_s());
      const LidarSpec& spec = scene_.world().sensors.lidar;
      reading.observation =
          spec.rotating_scan ? rotatingScan(sweep, spec) : pointCloud(sweep, spec);
      reading.points = sweep.points.size();
      label(*reading.observation, "lidar", e);
    } else if (e.sensor == Sensor::kCamera) {
      const CameraSpec& spec = scene_.world().sensors.camera;
      reading.image_file = "camera_" + stampName(e) + ".jpg";
      cv::imencode(".jpg", cameras_.local().image(e.index, e.t_s()), reading.image_bytes,
                   {cv::IMWRITE_JPEG_QUALITY, spec.jpeg_quality});
      reading.observation = imageObservation(spec, reading.image_file);
      label(*reading.observation, "camera", e);
    }
  }

 private:
  void label(mrpt::obs::CObservation& o, const char* name, const Event& e) const {
    o.sensorLabel = name;
    o.timestamp = mrptTime(scene_.world(), e.t_us);
  }
  std::string stampName(const Event& e) const {
    const std::int64_t us = startStamp(scene_.world().seed).ns / 1000 + e.t_us;
    char text[32];
    std::snprintf(text, sizeof(text), "%lld.%06lld", static_cast<long long>(us / 1'000'000),
                  static_cast<long long>(us % 1'000'000));
    return text;
  }

  const Scene& scene_;
  PoseOdometry odom3d_;
  WheelOdometry odom2d_;
  Pose3 last_T_odom_base_;
  tbb::enumerable_thread_specific<Lidar> lidars_{[this] { return Lidar(scene_); }};
  tbb::enumerable_thread_specific<Camera> cameras_{[this] { return Camera(scene_); }};
};

void createFolder(const fs::path& folder) {
  std::error_code failure;
  fs::create_directories(folder, failure);
  if (failure) throw DataError(folder.string() + ": cannot be created: " + failure.message());
}

}  // namespace

SimulationCounts simulate(const World& given, const fs::path& folder, int threads,
                          const KeepGoing& keep_going) {
  // What is simulated is exactly what the written world file says.
  const World world = parseWorld(worldYaml(given), given.name);
  requireFreeWay(world);
  createFolder(folder);
  const Scene scene(world);
  Recorder recorder(scene);
  Schedule schedule(world);
  RawlogWriter rawlog(folder, world.name);
  RobotTruth robot_truth(scene, folder);
  EntityTruth entity_truth(scene, folder);
  SimulationCounts counts;
  std::int64_t end_us = 0;

  using ReadingPtr = std::shared_ptr<Reading>;
  const auto begin = [&](tbb::flow_control& control) -> ReadingPtr {
    const auto event = schedule.next();
    if (!event || !keep_going(event->t_s())) {
      control.stop();
      return nullptr;
    }
    auto reading = std::make_shared<Reading>();
    reading->event = *event;
    recorder.readOdometry(*reading);
    return reading;
  };
  const auto sense = [&](ReadingPtr reading) {
    recorder.readSensor(*reading);
    return reading;
  };
  const auto write = [&](const ReadingPtr& reading) {
    rawlog.write(*reading);
    robot_truth.upTo(reading->event.t_us);
    entity_truth.upTo(reading->event.t_us);
    end_us = reading->event.t_us;
    counts.scans += reading->event.sensor == Sensor::kLidar;
    counts.images += reading->event.sensor == Sensor::kCamera;
    counts.points += reading->points;
  };
  cv::setNumThreads(1);
  const auto workers = static_cast<std::size_t>(std::max(threads, 1));
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, workers);
  tbb::parallel_pipeline(
      4 * workers,
      tbb::make_filter<void, ReadingPtr>(tbb::filter_mode::serial_in_order, begin) &
          tbb::make_filter<ReadingPtr, ReadingPtr>(tbb::filter_mode::parallel, sense) &
          tbb::make_filter<ReadingPtr, void>(tbb::filter_mode::serial_in_order, write));

  rawlog.finish();
  robot_truth.finish();
  entity_truth.finish(end_us);
  writeFileAtomically(folder / (world.name + "_entities.yaml"), entityYaml(world));
  writeFileAtomically(folder / (world.name + "_config.yaml"), slamConfigYaml(world));
  writeFileAtomically(folder / (world.name + "_world.yaml"), worldYaml(world));
  writeFileAtomically(folder / (world.name + "_meta.json"), metaJson(scene, counts));
  return counts;
}

}  // namespace dynemo::simulation
