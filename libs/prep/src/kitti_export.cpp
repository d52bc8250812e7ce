#include "dynemo/prep/kitti_export.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <system_error>

#include "dynemo/core/error.h"
#include "dynemo/core/output_file.h"
#include "dynemo/ingest/rawlog_source.h"
#include "rectification.h"

namespace dynemo {

namespace fs = std::filesystem;

namespace {

std::string number(std::uint64_t index) {
  char text[32];
  std::snprintf(text, sizeof(text), "%06llu", static_cast<unsigned long long>(index));
  return text;
}

std::string matrixRow(const Eigen::Matrix<double, 3, 4>& m) {
  std::string row;
  char value[40];
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) {
      std::snprintf(value, sizeof(value), "%s%.9e", row.empty() ? "" : " ", m(r, c));
      row += value;
    }
  return row;
}

std::string matrixRow(const Pose3& T) {
  Eigen::Matrix<double, 3, 4> m;
  m << T.R, T.t;
  return matrixRow(m);
}

std::string projectionRow(const CameraModel& c) {
  Eigen::Matrix<double, 3, 4> P = Eigen::Matrix<double, 3, 4>::Zero();
  P(0, 0) = c.fx;
  P(1, 1) = c.fy;
  P(0, 2) = c.cx;
  P(1, 2) = c.cy;
  P(2, 2) = 1.0;
  return matrixRow(P);
}

/// A folder that is renamed when it is complete, and removed when it is not.
class FolderInTheMaking {
 public:
  explicit FolderInTheMaking(const fs::path& folder)
      : folder_(folder), part_(folder.string() + ".part") {
    if (fs::exists(fs::symlink_status(folder)))
      throw DataError(folder.string() + ": exists already and is not overwritten");
    std::error_code failure;
    fs::remove_all(part_, failure);
    make(part_);
  }
  ~FolderInTheMaking() {
    std::error_code ignored;
    if (!complete_) fs::remove_all(part_, ignored);
  }
  FolderInTheMaking(const FolderInTheMaking&) = delete;
  FolderInTheMaking& operator=(const FolderInTheMaking&) = delete;

  fs::path in(const std::string& name) const {
    make(part_ / name);
    return part_ / name;
  }
  const fs::path& path() const { return part_; }
  void complete() {
    std::error_code failure;
    fs::rename(part_, folder_, failure);
    if (failure) throw DataError(folder_.string() + ": cannot be completed: " + failure.message());
    complete_ = true;
  }

 private:
  static void make(const fs::path& folder) {
    std::error_code failure;
    fs::create_directories(folder, failure);
    if (failure) throw DataError(folder.string() + ": cannot be made: " + failure.message());
  }
  fs::path folder_, part_;
  bool complete_ = false;
};

void writeCloud(const fs::path& file, const PointCloud& cloud) {
  std::ofstream out(file, std::ios::binary);
  for (const Eigen::Vector3f& p : cloud.points) {
    const float row[4] = {p.x(), p.y(), p.z(), 0.0F};
    out.write(reinterpret_cast<const char*>(row), sizeof(row));
  }
  out.close();
  if (!out) throw DataError(file.string() + ": cannot be written");
}

void writeImage(const fs::path& file, const cv::Mat& grey) {
  if (!cv::imwrite(file.string(), grey)) throw DataError(file.string() + ": cannot be written");
}

struct Camera {
  CameraModel model;
  Pose3 T_base_camera;
  /// Empty where there is no distortion, or where it stays.
  std::optional<Rectification> rectification;
};

/// What a lens does to the image, as calib_cam_to_cam.txt has it.
std::string distortionRow(const CameraModel& c) {
  std::size_t terms = 5;
  if (c.distortion == DistortionModel::kKannalaBrandt) terms = 4;
  if (c.distortion == DistortionModel::kPlumbBob &&
      std::any_of(c.coefficients.begin() + 5, c.coefficients.end(),
                  [](double k) { return k != 0; }))
    terms = 8;
  std::string row;
  char value[40];
  for (std::size_t i = 0; i < terms; ++i) {
    std::snprintf(value, sizeof(value), " %.6e", c.coefficients[i]);
    row += value;
  }
  return row;
}

/// Size, intrinsics and distortion of one camera, as in KITTI's raw data.
std::string recordedCalibration(const CameraModel& c, int index) {
  char text[300], name[16];
  std::snprintf(name, sizeof(name), "%02d", index);
  std::snprintf(text, sizeof(text),
                "S_%s: %.6e %.6e\nK_%s: %.6e %.6e %.6e %.6e %.6e %.6e %.6e %.6e %.6e\n", name,
                static_cast<double>(c.width), static_cast<double>(c.height), name, c.fx, 0.0, c.cx,
                0.0, c.fy, c.cy, 0.0, 0.0, 1.0);
  return std::string(text) + "D_" + name + ":" + distortionRow(c) + "\n";
}

bool distorts(const CameraModel& c) {
  return c.valid() && c.distortion != DistortionModel::kNone &&
         std::any_of(c.coefficients.begin(), c.coefficients.end(), [](double k) { return k != 0; });
}

/// The sequence while it grows.
class Sequence {
 public:
  Sequence(const fs::path& folder, KittiImages images) : folder_(folder), images_(images) {}

  void add(const SensorFrame& frame) {
    if (!first_) first_ = frame.stamp;
    times_ << exactTime(secondsBetween(*first_, frame.stamp)) << '\n';
    stamps_ << frame.stamp.text() << '\n';
    if (frame.scan) addScan(frame);
    for (const CameraImage& image : frame.images) addImage(image, frame.index);
    T_odom_base_.push_back(frame.odometry ? std::optional(frame.odometry->T_odom_base)
                                          : std::nullopt);
  }

  KittiReport finish(const IngestReport& ingest);

 private:
  static std::string exactTime(double seconds) {
    char text[32];
    std::snprintf(text, sizeof(text), "%.9f", seconds);
    return text;
  }
  void addScan(const SensorFrame& frame) {
    writeCloud(folder_.in("velodyne") / (number(frame.index) + ".bin"), frame.scan->cloud);
    if (!T_base_lidar_) T_base_lidar_ = frame.scan->T_base_lidar;
    ++report_.clouds;
  }
  void addImage(const CameraImage& image, std::uint64_t index) {
    // Folders are numbered by label at the end, when all are known.
    const auto [entry, first] =
        cameras_.try_emplace(image.label, Camera{image.model, image.T_base_camera, {}});
    Camera& camera = entry->second;
    if (first && distorts(image.model) && images_ == KittiImages::kRectified)
      camera.rectification.emplace(image.model);
    writeImage(folder_.in("camera " + hexadecimal(image.label)) / (number(index) + ".png"),
               camera.rectification ? (*camera.rectification)(image.grey) : image.grey);
    ++report_.images;
    if (camera.rectification)
      ++report_.rectified;
    else if (distorts(camera.model))
      ++report_.warnings["image with lens distortion, which only calib_cam_to_cam.txt tells"];
  }
  static std::string hexadecimal(const std::string& label) {
    std::string text;
    char digits[4];
    for (const char c : label) {
      std::snprintf(digits, sizeof(digits), "%02x", static_cast<unsigned char>(c));
      text += digits;
    }
    return text;
  }
  std::string calibration() const;
  std::string recordedCalibrations();
  std::string poses();

  FolderInTheMaking folder_;
  KittiImages images_;
  std::ostringstream times_, stamps_;
  std::optional<Stamp> first_;
  std::map<std::string, Camera> cameras_;
  std::optional<Pose3> T_base_lidar_;
  std::vector<std::optional<Pose3>> T_odom_base_;
  KittiReport report_;
};

std::string Sequence::calibration() const {
  std::string text;
  int index = 0;
  for (const auto& [label, camera] : cameras_)
    text += "P" + std::to_string(index++) + ": " + projectionRow(camera.model) + "\n";
  Pose3 T_camera_lidar;
  if (!cameras_.empty() && T_base_lidar_)
    T_camera_lidar = cameras_.begin()->second.T_base_camera.inverse() * *T_base_lidar_;
  return text + "Tr: " + matrixRow(T_camera_lidar) + "\n";
}

std::string Sequence::recordedCalibrations() {
  std::string text;
  int index = 0;
  for (const auto& [label, camera] : cameras_) {
    if (camera.model.distortion == DistortionModel::kKannalaBrandt)
      ++report_.warnings["camera with a fisheye lens: D in calib_cam_to_cam.txt is Kannala-Brandt"];
    text += recordedCalibration(camera.model, index++);
  }
  return text;
}

/// A frame without odometry keeps the last pose, so that the rows stay those of the frames.
std::string Sequence::poses() {
  Pose3 T_base_sensor;
  if (!cameras_.empty())
    T_base_sensor = cameras_.begin()->second.T_base_camera;
  else if (T_base_lidar_)
    T_base_sensor = *T_base_lidar_;
  std::optional<Pose3> T_odom_first, last;
  std::string text;
  std::uint64_t leading = 0, without = 0;
  for (const auto& T_odom_base : T_odom_base_) {
    if (T_odom_base) {
      last = *T_odom_base * T_base_sensor;
      if (!T_odom_first) T_odom_first = last;
      ++report_.poses;
    } else {
      ++without;
    }
    if (!last) {
      ++leading;
      continue;
    }
    for (; leading > 0; --leading) text += matrixRow(Pose3()) + "\n";
    text += matrixRow(T_odom_first->inverse() * *last) + "\n";
  }
  if (without > 0)
    report_.warnings[last ? "frame without odometry: pose of the one before it"
                          : "frame without odometry: there is no poses.txt"] += without;
  return last ? text : std::string();
}

KittiReport Sequence::finish(const IngestReport& ingest) {
  for (const auto& [what, times] : ingest.warnings) report_.warnings[what] += times;
  int index = 0;
  for (const auto& [label, camera] : cameras_)
    fs::rename(folder_.in("camera " + hexadecimal(label)),
               folder_.path() / ("image_" + std::to_string(index++)));
  writeFileAtomically(folder_.path() / "times.txt", times_.str());
  writeFileAtomically(folder_.path() / "stamps.txt", stamps_.str());
  writeFileAtomically(folder_.path() / "calib.txt", calibration());
  if (!cameras_.empty())
    writeFileAtomically(folder_.path() / "calib_cam_to_cam.txt", recordedCalibrations());
  const std::string rows = poses();
  if (!rows.empty()) writeFileAtomically(folder_.path() / "poses.txt", rows);
  if (report_.clouds + report_.images == 0)
    throw DataError("the log has neither scans nor images to export");
  folder_.complete();
  return report_;
}

}  // namespace

KittiReport exportKitti(const fs::path& rawlog, const fs::path& folder, const IngestParams& params,
                        KittiImages images) {
  const auto source = makeRawlogSource(params, rawlog);
  Sequence sequence(folder, images);
  while (const auto frame = source->next()) sequence.add(*frame);
  return sequence.finish(source->report());
}

}  // namespace dynemo
