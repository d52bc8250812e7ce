// A ROS 1 bag as plain values. ROS' own headers are valid up to C++17 only, so nothing here may
// need more, and no other file includes them.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <variant>
#include <vector>

namespace dynemo::ros1 {

struct Header {
  std::int64_t stamp_ns = 0;  ///< UNIX time; the time of reception when the message has none
  std::string frame_id;
};

/// sensor_msgs/PointCloud2
struct PointCloud {
  struct Field {
    std::string name;
    std::uint32_t offset = 0;
    std::uint8_t datatype = 0;  ///< of sensor_msgs/PointField
  };
  Header header;
  std::uint32_t height = 0, width = 0, point_step = 0, row_step = 0;
  bool is_bigendian = false;
  std::vector<Field> fields;
  std::vector<std::uint8_t> data;
};

/// sensor_msgs/Image
struct Image {
  Header header;
  std::uint32_t height = 0, width = 0, step = 0;
  std::string encoding;
  bool is_bigendian = false;
  std::vector<std::uint8_t> data;
};

/// sensor_msgs/CompressedImage
struct CompressedImage {
  Header header;
  std::string format;
  std::vector<std::uint8_t> data;
};

/// sensor_msgs/CameraInfo
struct CameraInfo {
  Header header;
  std::uint32_t height = 0, width = 0;
  std::string distortion_model;
  std::vector<double> D;
  std::array<double, 9> K{};
  std::array<double, 12> P{};
};

struct Pose {
  std::array<double, 3> position_m{};
  std::array<double, 4> quaternion_xyzw{};
};

/// nav_msgs/Odometry
struct Odometry {
  Header header;
  std::string child_frame_id;
  Pose pose;
  std::array<double, 36> covariance{};  ///< x y z, rotations about the fixed axes of the parent
};

/// tf2_msgs/TFMessage
struct Transforms {
  struct Transform {
    std::string parent, child;
    Pose pose;
  };
  std::vector<Transform> transforms;
};

using Message = std::variant<std::monostate, PointCloud, Image, CompressedImage, CameraInfo,
                             Odometry, Transforms>;

struct Record {
  std::string topic, type;
  Message message;  ///< std::monostate: of another type, or not asked for
};

class BagReader {
 public:
  /// Throws std::runtime_error, saying why, when the bag cannot be read.
  explicit BagReader(const std::string& file);
  ~BagReader();

  /// Every message in the order of reception; those whose type (as "sensor_msgs/Image") is not
  /// wanted come undecoded. Throws std::runtime_error where the bag is damaged.
  void forEach(const std::function<bool(const std::string& type)>& wanted,
               const std::function<void(Record)>& take) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace dynemo::ros1
