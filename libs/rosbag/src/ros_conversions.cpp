#include "ros_conversions.h"

#include <mrpt/maps/CPointsMapXYZI.h>
#include <mrpt/maps/CSimplePointsMap.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <opencv2/imgproc.hpp>

#include "dynemo/core/mrpt_conversions.h"

namespace dynemo {
namespace {

/// The types of sensor_msgs/PointField.
enum PointField : std::uint8_t {
  kInt8 = 1,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kFloat32,
  kFloat64
};

template <class T>
float readAs(const std::uint8_t* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(value));
  return static_cast<float>(value);
}

/// One field of a cloud: where it is in a point and how to read it.
struct FieldReader {
  std::size_t offset = 0, size = 0;
  float (*read)(const std::uint8_t*) = nullptr;
};

Expected<FieldReader, std::string> fieldReader(const ros1::PointCloud& message,
                                               const std::string& name) {
  for (const auto& field : message.fields) {
    if (field.name != name) continue;
    const std::size_t at = field.offset;
    switch (field.datatype) {
      case kInt8:
        return FieldReader{at, 1, readAs<std::int8_t>};
      case kUint8:
        return FieldReader{at, 1, readAs<std::uint8_t>};
      case kInt16:
        return FieldReader{at, 2, readAs<std::int16_t>};
      case kUint16:
        return FieldReader{at, 2, readAs<std::uint16_t>};
      case kInt32:
        return FieldReader{at, 4, readAs<std::int32_t>};
      case kUint32:
        return FieldReader{at, 4, readAs<std::uint32_t>};
      case kFloat32:
        return FieldReader{at, 4, readAs<float>};
      case kFloat64:
        return FieldReader{at, 8, readAs<double>};
      default:
        return make_unexpected("field " + name + " of an unknown type");
    }
  }
  return make_unexpected("no field " + name);
}

/// How an encoding of an image becomes 8-bit grey or BGR.
struct Encoding {
  int type;             ///< of the data
  int conversion = -1;  ///< OpenCV's, after the depth is reduced; −1: none
};

const std::map<std::string, Encoding>& encodings() {
  static const std::map<std::string, Encoding> table = {
      {"mono8", {CV_8UC1}},
      {"8UC1", {CV_8UC1}},
      {"mono16", {CV_16UC1}},
      {"16UC1", {CV_16UC1}},
      {"bgr8", {CV_8UC3}},
      {"8UC3", {CV_8UC3}},
      {"bgr16", {CV_16UC3}},
      {"rgb8", {CV_8UC3, cv::COLOR_RGB2BGR}},
      {"rgb16", {CV_16UC3, cv::COLOR_RGB2BGR}},
      {"bgra8", {CV_8UC4, cv::COLOR_BGRA2BGR}},
      {"8UC4", {CV_8UC4, cv::COLOR_BGRA2BGR}},
      {"rgba8", {CV_8UC4, cv::COLOR_RGBA2BGR}},
      // OpenCV names the patterns by their second row.
      {"bayer_rggb8", {CV_8UC1, cv::COLOR_BayerBG2BGR}},
      {"bayer_bggr8", {CV_8UC1, cv::COLOR_BayerRG2BGR}},
      {"bayer_gbrg8", {CV_8UC1, cv::COLOR_BayerGR2BGR}},
      {"bayer_grbg8", {CV_8UC1, cv::COLOR_BayerGB2BGR}},
      {"yuv422", {CV_8UC2, cv::COLOR_YUV2BGR_UYVY}},
      {"yuv422_yuy2", {CV_8UC2, cv::COLOR_YUV2BGR_YUY2}},
  };
  return table;
}

}  // namespace

Pose3 poseFrom(const ros1::Pose& pose) {
  const auto& [x, y, z, w] = pose.quaternion_xyzw;
  const auto& p = pose.position_m;
  return {Eigen::Quaterniond(w, x, y, z), Vector3(p[0], p[1], p[2])};
}

bool hasPointTimes(const ros1::PointCloud& message) {
  for (const auto& field : message.fields)
    for (const char* name :
         {"t", "time", "timestamp", "time_stamp", "offset_time", "time_sec", "time_nsec"})
      if (field.name == name) return true;
  return false;
}

Expected<mrpt::maps::CPointsMap::Ptr, std::string> cloudFrom(const ros1::PointCloud& message) {
  if (message.is_bigendian) return make_unexpected(std::string("big-endian data"));
  FieldReader xyz[3];
  const char* names[] = {"x", "y", "z"};
  std::size_t needed = 0;
  for (int i = 0; i < 3; ++i) {
    const auto reader = fieldReader(message, names[i]);
    if (!reader) return make_unexpected(reader.error());
    xyz[i] = *reader;
    needed = std::max(needed, reader->offset + reader->size);
  }
  const auto intensity = fieldReader(message, "intensity");
  if (intensity) needed = std::max(needed, intensity->offset + intensity->size);
  const std::size_t width = message.width, height = message.height;
  const std::size_t point_step = message.point_step;
  const std::size_t row_step = height > 1 ? message.row_step : width * point_step;
  if (point_step < needed || row_step < width * point_step ||
      (height > 0 && message.data.size() < (height - 1) * row_step + width * point_step))
    return make_unexpected(std::string("data shorter than its description"));

  const auto with_intensity = intensity ? mrpt::maps::CPointsMapXYZI::Create() : nullptr;
  const mrpt::maps::CPointsMap::Ptr cloud =
      intensity ? mrpt::maps::CPointsMap::Ptr(with_intensity)
                : mrpt::maps::CPointsMap::Ptr(mrpt::maps::CSimplePointsMap::Create());
  cloud->reserve(width * height);
  for (std::size_t row = 0; row < height; ++row)
    for (std::size_t column = 0; column < width; ++column) {
      const std::uint8_t* point = message.data.data() + row * row_step + column * point_step;
      float p[3];
      for (int i = 0; i < 3; ++i) p[i] = xyz[i].read(point + xyz[i].offset);
      if (!std::isfinite(p[0] + p[1] + p[2])) continue;
      cloud->insertPointFast(p[0], p[1], p[2]);
      // insertPointFast leaves the other fields to their own setters.
      if (with_intensity)
        with_intensity->setPointIntensity(cloud->size() - 1,
                                          intensity->read(point + intensity->offset));
    }
  cloud->mark_as_modified();
  return cloud;
}

Expected<cv::Mat, std::string> imageFrom(const ros1::Image& message) {
  const auto encoding = encodings().find(message.encoding);
  if (encoding == encodings().end())
    return make_unexpected("encoding " + message.encoding + " is not known");
  const int type = encoding->second.type;
  const std::size_t row_bytes = message.width * static_cast<std::size_t>(CV_ELEM_SIZE(type));
  if (message.width == 0 || message.height == 0 || message.step < row_bytes ||
      message.data.size() <
          (message.height - 1) * static_cast<std::size_t>(message.step) + row_bytes)
    return make_unexpected(std::string("data shorter than its description"));
  if (CV_MAT_DEPTH(type) == CV_16U && message.is_bigendian)
    return make_unexpected(std::string("big-endian data"));
  cv::Mat pixels = cv::Mat(static_cast<int>(message.height), static_cast<int>(message.width), type,
                           const_cast<std::uint8_t*>(message.data.data()), message.step)
                       .clone();
  if (pixels.depth() == CV_16U) pixels.convertTo(pixels, CV_8U, 1.0 / 256.0);
  if (encoding->second.conversion >= 0) cv::cvtColor(pixels, pixels, encoding->second.conversion);
  return pixels;
}

Expected<mrpt::img::TCamera, std::string> calibrationFrom(const ros1::CameraInfo& message,
                                                          bool rectified) {
  mrpt::img::TCamera camera;
  camera.ncols = message.width;
  camera.nrows = message.height;
  if (rectified) {
    camera.setIntrinsicParamsFromValues(message.P[0], message.P[5], message.P[2], message.P[6]);
    camera.distortion = mrpt::img::DistortionModel::none;
    return camera;
  }
  camera.setIntrinsicParamsFromValues(message.K[0], message.K[4], message.K[2], message.K[5]);
  const auto& d = message.D;
  const std::string& model = message.distortion_model;
  if (d.empty() || std::all_of(d.begin(), d.end(), [](double k) { return k == 0.0; })) {
    camera.distortion = mrpt::img::DistortionModel::none;
  } else if ((model == "plumb_bob" || model == "rational_polynomial" || model.empty()) &&
             d.size() <= camera.dist.size()) {
    camera.distortion = mrpt::img::DistortionModel::plumb_bob;
    camera.dist.fill(0.0);
    std::copy(d.begin(), d.end(), camera.dist.begin());
  } else if ((model == "equidistant" || model == "fisheye") && d.size() == 4) {
    camera.setDistortionKannalaBrandt(d[0], d[1], d[2], d[3]);
  } else {
    return make_unexpected("distortion model " + model + " with " + std::to_string(d.size()) +
                           " coefficients is not known");
  }
  return camera;
}

mrpt::poses::CPose3DPDFGaussian odometryFrom(const ros1::Odometry& message,
                                             const Pose3& T_child_base) {
  const Pose3 T_odom_child = poseFrom(message.pose);
  const Pose3 T_odom_base = (T_odom_child * T_child_base).normalized();
  const Matrix6 fixed_axes =
      Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(message.covariance.data());
  mrpt::poses::CPose3DPDFGaussian pose;
  pose.mean = toMrpt(T_odom_base);
  // All zeros is MRPT's way to say that there is none.
  pose.cov.setZero();
  if (!fixed_axes.allFinite() || fixed_axes.isZero(0.0)) return pose;
  Matrix6 B = Matrix6::Zero();
  B.topLeftCorner<3, 3>() = B.bottomRightCorner<3, 3>() = T_odom_child.R.transpose();
  const Matrix6 A = composeJacobianLeft(T_child_base);
  return toMrptGaussian(T_odom_base, A * B * fixed_axes * B.transpose() * A.transpose());
}

}  // namespace dynemo
