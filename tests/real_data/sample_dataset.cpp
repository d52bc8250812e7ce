#include "sample_dataset.h"

#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/maps/registerAllClasses.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/registerAllClasses.h>
#include <mrpt/serialization/CArchive.h>

#include <cstdlib>
#include <deque>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "dynemo/core/error.h"
#include "dynemo/core/mrpt_conversions.h"

namespace dynemo::test {
namespace {

std::optional<std::filesystem::path> folderFrom(const char* variable) {
  const char* value = std::getenv(variable);
  if (!value || !*value) return std::nullopt;
  return std::filesystem::path(value);
}

std::vector<std::string> split(const std::string& line, char separator) {
  std::vector<std::string> words;
  std::stringstream in(line);
  for (std::string word; std::getline(in, word, separator);) words.push_back(word);
  return words;
}

/// x y z qx qy qz qw from words[first].
Pose3 parsePose(const std::vector<std::string>& words, std::size_t first) {
  std::array<double, 7> v{};
  for (std::size_t i = 0; i < v.size(); ++i) v[i] = std::stod(words.at(first + i));
  return {Eigen::Quaterniond(v[6], v[3], v[4], v[5]), Vector3(v[0], v[1], v[2])};
}

std::map<EntityId, EntityBox> readBoxes(const std::filesystem::path& file) {
  std::map<EntityId, EntityBox> boxes;
  const nlohmann::json meta = nlohmann::json::parse(std::ifstream(file));
  for (const auto& entity : meta.at("entities")) {
    const auto corner = [&](int i) {
      const auto& c = entity.at("bbox_entity_frame").at(static_cast<std::size_t>(i));
      return Vector3(c.at(0).get<double>(), c.at(1).get<double>(), c.at(2).get<double>());
    };
    boxes[EntityId{entity.at("id").get<std::int64_t>()}] = {corner(0), corner(1)};
  }
  return boxes;
}

std::vector<TruePlane> readPlanes(const std::filesystem::path& file) {
  std::vector<TruePlane> planes;
  const nlohmann::json meta = nlohmann::json::parse(std::ifstream(file));
  for (const auto& entry : meta.at("planes")) {
    TruePlane plane;
    plane.name = entry.at("name").get<std::string>();
    const auto n = entry.at("n").get<std::array<double, 3>>();
    plane.plane_world = {Vector3(n[0], n[1], n[2]), entry.at("d").get<double>()};
    if (plane.isWall()) {
      const auto& extent = entry.at("extent");
      const auto a = extent.at("a").get<std::array<double, 2>>();
      const auto b = extent.at("b").get<std::array<double, 2>>();
      const auto z = extent.at("z").get<std::array<double, 2>>();
      plane.from = {a[0], a[1]};
      plane.to = {b[0], b[1]};
      plane.z_min_m = z[0];
      plane.z_max_m = z[1];
    }
    planes.push_back(plane);
  }
  return planes;
}

CameraModel cameraModel(const mrpt::img::TCamera& c) {
  CameraModel model;
  model.width = static_cast<int>(c.ncols);
  model.height = static_cast<int>(c.nrows);
  model.fx = c.fx();
  model.fy = c.fy();
  model.cx = c.cx();
  model.cy = c.cy();
  for (std::size_t i = 0; i < model.coefficients.size(); ++i) model.coefficients[i] = c.dist[i];
  const bool distorted = c.distortion == mrpt::img::DistortionModel::plumb_bob;
  model.distortion = distorted ? DistortionModel::kPlumbBob : DistortionModel::kNone;
  return model;
}

}  // namespace

std::optional<std::filesystem::path> samplesFolder() { return folderFrom("DYNEMO_SAMPLES"); }
std::optional<std::filesystem::path> realDataFolder() { return folderFrom("DYNEMO_REAL_DATA"); }

bool TruePlane::contains(const Vector3& p, double tolerance_m) const {
  if (std::abs(plane_world.distance(p)) > tolerance_m) return false;
  if (!isWall()) return true;
  const double s = (p.head<2>() - from).dot((to - from).normalized());
  return s > 0.0 && s < (to - from).norm() && p.z() > z_min_m && p.z() < z_max_m;
}

SampleTruth::SampleTruth(const std::filesystem::path& folder, const std::string& name) {
  std::ifstream robot(folder / (name + "_gt_robot.tum"));
  for (std::string line; std::getline(robot, line);) {
    if (line.empty() || line[0] == '#') continue;
    const auto words = split(line, ' ');
    robot_[Stamp::parse(words.at(0))] = parsePose(words, 1);
  }
  std::ifstream entities(folder / (name + "_gt_entities.csv"));
  std::string header;
  std::getline(entities, header);
  for (std::string line; std::getline(entities, line);) {
    const auto words = split(line, ',');
    entities_[EntityId{std::stoll(words.at(0))}][Stamp::parse(words.at(2))] = parsePose(words, 3);
  }
  if (robot_.empty() || entities_.empty()) throw DataError(folder.string() + ": no ground truth");
  boxes_ = readBoxes(folder / (name + "_meta.json"));
  planes_ = readPlanes(folder / (name + "_meta.json"));
}

std::optional<Pose3> SampleTruth::at(const Track& track, Stamp stamp) {
  const auto after = track.lower_bound(stamp);
  if (after == track.end()) return std::nullopt;
  if (after->first == stamp) return after->second;
  if (after == track.begin()) return std::nullopt;
  const auto before = std::prev(after);
  const double s =
      secondsBetween(before->first, stamp) / secondsBetween(before->first, after->first);
  return interpolate(before->second, after->second, s);
}

std::optional<Pose3> SampleTruth::T_world_base(Stamp stamp) const { return at(robot_, stamp); }

std::optional<Pose3> SampleTruth::T_world_entity(EntityId entity, Stamp stamp) const {
  const auto it = entities_.find(entity);
  return it == entities_.end() ? std::nullopt : at(it->second, stamp);
}

std::optional<Pose3> SampleTruth::T_base_entity(EntityId entity, Stamp stamp) const {
  const auto robot = T_world_base(stamp), target = T_world_entity(entity, stamp);
  if (!robot || !target) return std::nullopt;
  return robot->inverse() * *target;
}

struct SampleFrames::Impl {
  mrpt::io::CFileGZInputStream in;
  std::filesystem::path image_folder;
  std::deque<std::pair<Stamp, Pose3>> odometry;
  std::deque<CameraImage> images;
  std::deque<Scan> scans;
  bool at_end = false;
  std::uint64_t index = 0;

  /// Takes one observation in; false at the end.
  bool read() {
    auto archive = mrpt::serialization::archiveFrom(in);
    try {
      take(archive.ReadObject());
    } catch (const mrpt::serialization::CExceptionEOF&) {
      return false;
    }
    return true;
  }

  void take(const mrpt::serialization::CSerializable::Ptr& object) {
    if (auto pose = std::dynamic_pointer_cast<mrpt::obs::CObservationRobotPose>(object)) {
      odometry.emplace_back(fromMrpt(pose->timestamp), fromMrpt(pose->pose.mean));
    } else if (auto image = std::dynamic_pointer_cast<mrpt::obs::CObservationImage>(object)) {
      takeImage(*image);
    } else if (auto cloud = std::dynamic_pointer_cast<mrpt::obs::CObservationPointCloud>(object)) {
      takeScan(*cloud);
    }
  }

  void takeImage(const mrpt::obs::CObservationImage& observation) {
    CameraImage image;
    image.stamp = fromMrpt(observation.timestamp);
    image.label = observation.sensorLabel;
    image.model = cameraModel(observation.cameraParams);
    image.T_base_camera = fromMrpt(observation.cameraPose);
    const auto file = image_folder / observation.image.getExternalStorageFile();
    image.grey = cv::imread(file.string(), cv::IMREAD_GRAYSCALE);
    images.push_back(std::move(image));
  }

  void takeScan(mrpt::obs::CObservationPointCloud& observation) {
    Scan scan;
    scan.stamp = fromMrpt(observation.timestamp);
    scan.T_base_lidar = fromMrpt(observation.sensorPose);
    const auto &xs = observation.pointcloud->getPointsBufferRef_x(),
               &ys = observation.pointcloud->getPointsBufferRef_y(),
               &zs = observation.pointcloud->getPointsBufferRef_z();
    for (std::size_t i = 0; i < xs.size(); ++i) {
      scan.cloud.points.emplace_back(xs[i], ys[i], zs[i]);
    }
    scans.push_back(std::move(scan));
  }

  std::optional<OdometryState> odometryAt(Stamp stamp) const {
    for (std::size_t i = 0; i + 1 < odometry.size(); ++i) {
      const auto& [t0, T0] = odometry[i];
      const auto& [t1, T1] = odometry[i + 1];
      if (stamp < t0 || stamp > t1) continue;
      const double s = secondsBetween(t0, stamp) / secondsBetween(t0, t1);
      return OdometryState{interpolate(T0, T1, s), std::nullopt};
    }
    return std::nullopt;
  }

  /// Whether everything that belongs to the oldest image has been read.
  bool complete() const {
    constexpr double kLookAhead_s = 0.2;
    return !images.empty() && !odometry.empty() &&
           secondsBetween(images.front().stamp, odometry.back().first) > kLookAhead_s;
  }
};

SampleFrames::SampleFrames(const std::filesystem::path& folder, const std::string& name)
    : impl_(std::make_unique<Impl>()) {
  mrpt::obs::registerAllClasses_mrpt_obs();
  mrpt::maps::registerAllClasses_mrpt_maps();
  impl_->image_folder = folder / (name + "_Images");
  impl_->in.open((folder / (name + ".rawlog")).string());
}

SampleFrames::~SampleFrames() = default;

std::optional<SensorFrame> SampleFrames::next() {
  while (!impl_->complete() && !impl_->at_end) impl_->at_end = !impl_->read();
  if (impl_->images.empty()) return std::nullopt;
  SensorFrame frame;
  frame.index = impl_->index++;
  CameraImage image = std::move(impl_->images.front());
  impl_->images.pop_front();
  frame.stamp = image.stamp;
  image.odometry = impl_->odometryAt(image.stamp);
  frame.odometry = image.odometry;
  while (!impl_->scans.empty() && impl_->scans.front().stamp < frame.stamp) {
    impl_->scans.pop_front();
  }
  if (!impl_->scans.empty() && impl_->scans.front().stamp == frame.stamp) {
    frame.scan = std::move(impl_->scans.front());
    impl_->scans.pop_front();
  }
  frame.images.push_back(std::move(image));
  while (impl_->odometry.size() > 20) impl_->odometry.pop_front();
  return frame;
}

}  // namespace dynemo::test
