#include "bag_reader.h"

#include <nav_msgs/Odometry.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <stdexcept>

namespace dynemo::ros1 {
namespace {

using rosbag::MessageInstance;

std::int64_t nanoseconds(const ros::Time& time) {
  return static_cast<std::int64_t>(time.sec) * 1'000'000'000 + time.nsec;
}

Header header(const std_msgs::Header& h, const MessageInstance& m) {
  return {nanoseconds(h.stamp.isZero() ? m.getTime() : h.stamp), h.frame_id};
}

template <class Point, class Quaternion>
Pose pose(const Point& p, const Quaternion& q) {
  return {{p.x, p.y, p.z}, {q.x, q.y, q.z, q.w}};
}

Message convert(sensor_msgs::PointCloud2& in, const MessageInstance& m) {
  PointCloud out;
  out.header = header(in.header, m);
  out.height = in.height;
  out.width = in.width;
  out.point_step = in.point_step;
  out.row_step = in.row_step;
  out.is_bigendian = in.is_bigendian != 0;
  for (const auto& field : in.fields)
    out.fields.push_back({field.name, field.offset, field.datatype});
  out.data = std::move(in.data);
  return out;
}

Message convert(sensor_msgs::Image& in, const MessageInstance& m) {
  Image out;
  out.header = header(in.header, m);
  out.height = in.height;
  out.width = in.width;
  out.step = in.step;
  out.encoding = in.encoding;
  out.is_bigendian = in.is_bigendian != 0;
  out.data = std::move(in.data);
  return out;
}

Message convert(sensor_msgs::CompressedImage& in, const MessageInstance& m) {
  CompressedImage out;
  out.header = header(in.header, m);
  out.format = in.format;
  out.data = std::move(in.data);
  return out;
}

Message convert(sensor_msgs::CameraInfo& in, const MessageInstance& m) {
  CameraInfo out;
  out.header = header(in.header, m);
  out.height = in.height;
  out.width = in.width;
  out.distortion_model = in.distortion_model;
  out.D = in.D;
  std::copy(in.K.begin(), in.K.end(), out.K.begin());
  std::copy(in.P.begin(), in.P.end(), out.P.begin());
  return out;
}

Message convert(nav_msgs::Odometry& in, const MessageInstance& m) {
  Odometry out;
  out.header = header(in.header, m);
  out.child_frame_id = in.child_frame_id;
  out.pose = pose(in.pose.pose.position, in.pose.pose.orientation);
  std::copy(in.pose.covariance.begin(), in.pose.covariance.end(), out.covariance.begin());
  return out;
}

Message convert(tf2_msgs::TFMessage& in, const MessageInstance&) {
  Transforms out;
  for (const auto& t : in.transforms)
    out.transforms.push_back(
        {t.header.frame_id, t.child_frame_id, pose(t.transform.translation, t.transform.rotation)});
  return out;
}

/// The message as the first of these types that it is.
template <class First, class... Rest>
Message decode(const MessageInstance& m) {
  // Types are told by their checksums, so that tf/tfMessage is a tf2_msgs/TFMessage too.
  if (m.isType<First>()) return convert(*m.instantiate<First>(), m);
  if constexpr (sizeof...(Rest) > 0)
    return decode<Rest...>(m);
  else
    return {};
}

}  // namespace

struct BagReader::Impl {
  rosbag::Bag bag;
};

BagReader::BagReader(const std::string& file) : impl_(std::make_unique<Impl>()) {
  try {
    impl_->bag.open(file, rosbag::bagmode::Read);
  } catch (const rosbag::BagUnindexedException&) {
    throw std::runtime_error("the bag has no index; 'rosbag reindex' makes one");
  } catch (const std::exception& e) {
    throw std::runtime_error(std::string("is no ROS 1 bag that can be read: ") + e.what());
  }
}

BagReader::~BagReader() = default;

void BagReader::forEach(const std::function<bool(const std::string& type)>& wanted,
                        const std::function<void(Record)>& take) const {
  rosbag::View view(impl_->bag);
  for (const MessageInstance& m : view) {
    Record record{m.getTopic(), m.getDataType(), {}};
    if (wanted(record.type))
      record.message =
          decode<sensor_msgs::PointCloud2, sensor_msgs::Image, sensor_msgs::CompressedImage,
                 sensor_msgs::CameraInfo, nav_msgs::Odometry, tf2_msgs::TFMessage>(m);
    take(std::move(record));
  }
}

}  // namespace dynemo::ros1
