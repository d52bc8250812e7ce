#include "dynemo/rosbag/rosbag_import.h"

#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "bag_reader.h"
#include "dynemo/core/error.h"
#include "dynemo/core/mrpt_conversions.h"
#include "dynemo/ingest/rawlog_reader.h"
#include "dynemo/prep/rawlog_output.h"
#include "frame_tree.h"
#include "ros_conversions.h"

namespace dynemo {

namespace fs = std::filesystem;

namespace {

/// "/camera/image_raw" → "camera_image_raw".
std::string labelOf(const std::string& topic) {
  std::string label = topic.substr(
      topic.find_first_not_of('/') == std::string::npos ? 0 : topic.find_first_not_of('/'));
  std::replace(label.begin(), label.end(), '/', '_');
  return label;
}

/// Where the CameraInfo of an image topic is published: beside it, under the name camera_info.
std::string cameraInfoTopic(std::string image_topic) {
  constexpr std::string_view kCompressed = "/compressed";
  if (image_topic.ends_with(kCompressed))
    image_topic.resize(image_topic.size() - kCompressed.size());
  return image_topic.substr(0, image_topic.rfind('/')) + "/camera_info";
}

/// ".jpg" or ".png" by the first bytes, else empty.
std::string imageExtension(const std::vector<std::uint8_t>& data) {
  const auto begins = [&](std::initializer_list<std::uint8_t> magic) {
    return data.size() > magic.size() && std::equal(magic.begin(), magic.end(), data.begin());
  };
  if (begins({0xFF, 0xD8, 0xFF})) return ".jpg";
  if (begins({0x89, 'P', 'N', 'G'})) return ".png";
  return {};
}

void writeBytes(const fs::path& file, const std::vector<std::uint8_t>& bytes) {
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()),
            static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) throw DataError(file.string() + ": cannot be written");
}

/// What must be known of a bag before its sensors can be converted.
struct Setting {
  FrameTree frames;
  std::map<std::string, ros1::CameraInfo> calibrations;  ///< by topic: the first
  std::string odometry_child;
};

class Import {
 public:
  Import(const fs::path& bag, const fs::path& rawlog, const RosbagImportParams& params)
      : file_(bag), params_(params), bag_(openBag(bag)), output_(rawlog, params.compressed) {}

  RosbagImportReport run() {
    forEachMessage([](const std::string& type) { return tellsOfTheSetting(type); },
                   [this](const ros1::Record& r) { learn(r); });
    chooseBaseFrame();
    forEachMessage(
        [](const std::string& type) { return !tellsOfTheSetting(type) || isOdometry(type); },
        [this](const ros1::Record& r) { convert(r); });
    report_.warnings = warnings_.counts();
    if (report_.written.empty())
      throw DataError(file_.string() + ": holds no message that can be imported" + leftOutText());
    output_.commit();
    return report_;
  }

 private:
  static std::unique_ptr<ros1::BagReader> openBag(const fs::path& bag) {
    try {
      return std::make_unique<ros1::BagReader>(bag.string());
    } catch (const std::exception& e) {
      throw DataError(bag.string() + ": " + e.what());
    }
  }
  static bool isOdometry(const std::string& type) { return type == "nav_msgs/Odometry"; }
  static bool tellsOfTheSetting(const std::string& type) {
    return isOdometry(type) || type == "sensor_msgs/CameraInfo" || type == "tf2_msgs/TFMessage" ||
           type == "tf/tfMessage";
  }
  void forEachMessage(const std::function<bool(const std::string&)>& wanted,
                      const std::function<void(const ros1::Record&)>& take);
  void learn(const ros1::Record& record);
  void chooseBaseFrame();
  void convert(const ros1::Record& record);
  // One for each kind of message.
  void take(const ros1::PointCloud& message, const std::string& topic, const std::string& label);
  void take(const ros1::Image& message, const std::string& topic, const std::string& label);
  void take(const ros1::CompressedImage& message, const std::string& topic,
            const std::string& label);
  void take(const ros1::Odometry& message, const std::string& topic, const std::string& label);
  void writeImage(const ros1::Header& header, const std::string& topic, const std::string& label,
                  const std::string& extension,
                  const std::function<void(const fs::path&)>& write_file);
  mrpt::img::TCamera calibration(const std::string& topic);
  Pose3 mounting(const std::string& frame, const std::string& label);
  void finish(mrpt::obs::CObservation& o, Stamp stamp, const std::string& label);
  std::string leftOutText() const;
  /// The label of a topic that is wanted.
  std::optional<std::string> wanted(const std::string& topic) const {
    if (params_.labels.empty()) return labelOf(topic);
    const auto it = params_.labels.find(topic);
    return it == params_.labels.end() ? std::nullopt : std::optional(it->second);
  }

  fs::path file_;
  const RosbagImportParams& params_;
  std::unique_ptr<ros1::BagReader> bag_;
  RawlogOutput output_;
  Setting setting_;
  WarningCounter warnings_;
  bool damage_counted_ = false;
  RosbagImportReport report_;
};

/// A bag that cannot be read on ends there.
void Import::forEachMessage(const std::function<bool(const std::string&)>& wanted,
                            const std::function<void(const ros1::Record&)>& take) {
  try {
    bag_->forEach(wanted, take);
  } catch (const DataError&) {
    throw;
  } catch (const std::exception& e) {
    if (!damage_counted_)
      warnings_.count(std::string("bag damaged, the rest is not used: ") + e.what());
    damage_counted_ = true;
  }
}

void Import::learn(const ros1::Record& record) {
  if (const auto* tf = std::get_if<ros1::Transforms>(&record.message)) {
    for (const auto& t : tf->transforms)
      setting_.frames.add(FrameTree::normalized(t.parent), FrameTree::normalized(t.child),
                          poseFrom(t.pose));
  } else if (const auto* info = std::get_if<ros1::CameraInfo>(&record.message)) {
    setting_.calibrations.try_emplace(record.topic, *info);
  } else if (const auto* odometry = std::get_if<ros1::Odometry>(&record.message)) {
    if (setting_.odometry_child.empty())
      setting_.odometry_child = FrameTree::normalized(odometry->child_frame_id);
  }
}

void Import::chooseBaseFrame() {
  report_.base_frame = FrameTree::normalized(params_.base_frame);
  for (const std::string frame : {"base_link", "base_footprint"})
    if (report_.base_frame.empty() && setting_.frames.knows(frame)) report_.base_frame = frame;
  if (report_.base_frame.empty()) report_.base_frame = setting_.odometry_child;
  if (!params_.base_frame.empty() && !setting_.frames.knows(report_.base_frame) &&
      report_.base_frame != setting_.odometry_child)
    throw ConfigError(file_.string() + ": no tf message knows the frame '" + params_.base_frame +
                      "'");
}

void Import::convert(const ros1::Record& record) {
  if (tellsOfTheSetting(record.type) && !isOdometry(record.type)) return;
  const auto label = wanted(record.topic);
  if (!label || std::holds_alternative<std::monostate>(record.message)) {
    ++report_.left_out[record.topic + " (" + record.type + ")"];
    return;
  }
  std::visit(
      [&](const auto& message) {
        using T = std::decay_t<decltype(message)>;
        if constexpr (!std::is_same_v<T, std::monostate> && !std::is_same_v<T, ros1::CameraInfo> &&
                      !std::is_same_v<T, ros1::Transforms>)
          take(message, record.topic, *label);
      },
      record.message);
}

void Import::finish(mrpt::obs::CObservation& o, Stamp stamp, const std::string& label) {
  o.timestamp = toMrpt(stamp);
  o.sensorLabel = label;
  output_.write(o);
  ++report_.written[label + " (" + shortClassName(o) + ")"];
}

Pose3 Import::mounting(const std::string& frame_id, const std::string& label) {
  const std::string frame = FrameTree::normalized(frame_id);
  const std::string& base = report_.base_frame;
  const auto T_base_sensor =
      base.empty() ? std::optional<Pose3>() : setting_.frames.find(base, frame);
  if (!T_base_sensor) {
    warnings_.count("'" + label + "' put into the robot's origin: no tf from " +
                    (base.empty() ? "a base frame" : "'" + base + "'") + " to '" + frame + "'");
    return {};
  }
  if (setting_.frames.changes(base, frame))
    warnings_.count("'" + label + "' moves against the robot: the first tf is used for all");
  return *T_base_sensor;
}

void Import::take(const ros1::PointCloud& message, const std::string&, const std::string& label) {
  const auto cloud = cloudFrom(message);
  if (!cloud) return warnings_.count("cloud of '" + label + "' left out: " + cloud.error());
  if (hasPointTimes(message))
    warnings_.count("cloud of '" + label +
                    "' has times per point, which MRPT's clouds cannot hold: " +
                    "set sensors.lidar.sweep_rate_hz");
  const std::uint64_t all = static_cast<std::uint64_t>(message.width) * message.height;
  warnings_.count("'" + label + "': points that are not finite left out", all - (*cloud)->size());
  mrpt::obs::CObservationPointCloud o;
  o.pointcloud = *cloud;
  o.sensorPose = toMrpt(mounting(message.header.frame_id, label));
  finish(o, Stamp{message.header.stamp_ns}, label);
}

mrpt::img::TCamera Import::calibration(const std::string& topic) {
  const auto info = setting_.calibrations.find(cameraInfoTopic(topic));
  if (info == setting_.calibrations.end()) {
    warnings_.count("image of " + topic + " without calibration: there is no " +
                    cameraInfoTopic(topic));
    return {};
  }
  const bool rectified = topic.find("rect") != std::string::npos;
  const auto camera = calibrationFrom(info->second, rectified);
  if (camera) return *camera;
  warnings_.count("image of " + topic + " without calibration: " + camera.error());
  return {};
}

void Import::writeImage(const ros1::Header& header, const std::string& topic,
                        const std::string& label, const std::string& extension,
                        const std::function<void(const fs::path&)>& write_file) {
  const Stamp stamp{header.stamp_ns};
  const std::string name = output_.freeImageName(label + "_" + stamp.text(), extension, {});
  write_file(output_.imageFolder() / name);
  mrpt::obs::CObservationImage o;
  o.image.setExternalStorage(name);
  o.cameraParams = calibration(topic);
  o.cameraPose = toMrpt(mounting(header.frame_id, label));
  finish(o, stamp, label);
}

void Import::take(const ros1::Image& message, const std::string& topic, const std::string& label) {
  const auto pixels = imageFrom(message);
  if (!pixels) return warnings_.count("image of '" + label + "' left out: " + pixels.error());
  writeImage(message.header, topic, label, ".png", [&](const fs::path& file) {
    if (!cv::imwrite(file.string(), *pixels))
      throw DataError(file.string() + ": cannot be written");
  });
}

void Import::take(const ros1::CompressedImage& message, const std::string& topic,
                  const std::string& label) {
  const std::string extension = imageExtension(message.data);
  if (extension.empty())
    return warnings_.count("image of '" + label + "' left out: neither JPEG nor PNG but " +
                           message.format);
  writeImage(message.header, topic, label, extension,
             [&](const fs::path& file) { writeBytes(file, message.data); });
}

void Import::take(const ros1::Odometry& message, const std::string&, const std::string& label) {
  const std::string child = FrameTree::normalized(message.child_frame_id);
  Pose3 T_child_base;
  if (!report_.base_frame.empty() && child != report_.base_frame)
    T_child_base = mounting(child, label).inverse();
  mrpt::obs::CObservationRobotPose o;
  o.pose = odometryFrom(message, T_child_base);
  finish(o, Stamp{message.header.stamp_ns}, label);
}

std::string Import::leftOutText() const {
  std::string text;
  for (const auto& [topic, count] : report_.left_out)
    text += (text.empty() ? "; it has " : ", ") + topic;
  for (const auto& [what, count] : warnings_.counts()) text += "; " + what;
  return text;
}

}  // namespace

RosbagImportReport importRosbag(const fs::path& bag, const fs::path& rawlog,
                                const RosbagImportParams& params) {
  std::error_code ignored;
  if (!fs::exists(bag, ignored)) throw DataError(bag.string() + ": no such file");
  if (!fs::is_regular_file(bag, ignored))
    throw DataError(bag.string() + ": is no file but a folder or device");
  return Import(bag, rawlog, params).run();
}

}  // namespace dynemo
