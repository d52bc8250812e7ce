#include "bag_writer.h"

#include <nav_msgs/Odometry.h>
#include <rosbag/bag.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_msgs/TFMessage.h>

#include <cstring>

namespace dynemo::test {
namespace {

constexpr std::uint32_t kPointStep = 20;

sensor_msgs::PointField field(const char* name, std::uint32_t offset) {
  sensor_msgs::PointField f;
  f.name = name;
  f.offset = offset;
  f.datatype = sensor_msgs::PointField::FLOAT32;
  f.count = 1;
  return f;
}

}  // namespace

struct BagWriter::Impl {
  rosbag::Bag bag;
  template <class Message>
  void write(const std::string& topic, double stamp_s, const Message& message) {
    bag.write(topic, ros::Time(stamp_s + 0.25), message);  // received later
  }
};

BagWriter::BagWriter(const std::string& file) : impl_(new Impl) {
  impl_->bag.open(file, rosbag::bagmode::Write);
}
BagWriter::~BagWriter() {
  impl_->bag.close();
  delete impl_;
}

void BagWriter::cloud(const std::string& topic, double stamp_s, const std::string& frame,
                      const std::vector<std::array<float, 3>>& points,
                      const std::vector<float>& intensities, const char* time_field) {
  sensor_msgs::PointCloud2 m;
  if (stamp_s > 0) m.header.stamp = ros::Time(stamp_s);
  m.header.frame_id = frame;
  m.height = 1;
  m.width = static_cast<std::uint32_t>(points.size());
  m.point_step = kPointStep;
  m.row_step = kPointStep * m.width;
  m.fields = {field("x", 0), field("y", 4), field("z", 8)};
  if (!intensities.empty()) m.fields.push_back(field("intensity", 16));
  if (time_field) m.fields.push_back(field(time_field, 12));
  m.data.resize(m.row_step, 0xAB);
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::memcpy(&m.data[i * kPointStep], points[i].data(), 12);
    if (!intensities.empty()) std::memcpy(&m.data[i * kPointStep + 16], &intensities[i], 4);
  }
  impl_->write(topic, stamp_s > 0 ? stamp_s : 100.0, m);
}

void BagWriter::image(const std::string& topic, double stamp_s, const std::string& frame,
                      const std::string& encoding, std::uint32_t width, std::uint32_t height,
                      const std::vector<std::uint8_t>& data) {
  sensor_msgs::Image m;
  m.header.stamp = ros::Time(stamp_s);
  m.header.frame_id = frame;
  m.encoding = encoding;
  m.width = width;
  m.height = height;
  m.step = static_cast<std::uint32_t>(data.size() / height);
  m.data = data;
  impl_->write(topic, stamp_s, m);
}

void BagWriter::compressedImage(const std::string& topic, double stamp_s, const std::string& frame,
                                const std::vector<std::uint8_t>& data) {
  sensor_msgs::CompressedImage m;
  m.header.stamp = ros::Time(stamp_s);
  m.header.frame_id = frame;
  m.format = "jpeg";
  m.data = data;
  impl_->write(topic, stamp_s, m);
}

void BagWriter::cameraInfo(const std::string& topic, double stamp_s, std::uint32_t width,
                           std::uint32_t height, const std::string& model,
                           const std::vector<double>& D) {
  sensor_msgs::CameraInfo m;
  m.header.stamp = ros::Time(stamp_s);
  m.width = width;
  m.height = height;
  m.distortion_model = model;
  m.D = D;
  m.K = {60, 0, 31, 0, 61, 23, 0, 0, 1};
  m.P = {70, 0, 32, 0, 0, 71, 24, 0, 0, 0, 1, 0};
  impl_->write(topic, stamp_s, m);
}

void BagWriter::odometry(const std::string& topic, double stamp_s, const std::string& child,
                         const std::array<double, 3>& position,
                         const std::array<double, 4>& quaternion_xyzw,
                         const std::array<double, 36>& covariance) {
  nav_msgs::Odometry m;
  m.header.stamp = ros::Time(stamp_s);
  m.header.frame_id = "odom";
  m.child_frame_id = child;
  m.pose.pose.position.x = position[0];
  m.pose.pose.position.y = position[1];
  m.pose.pose.position.z = position[2];
  m.pose.pose.orientation.x = quaternion_xyzw[0];
  m.pose.pose.orientation.y = quaternion_xyzw[1];
  m.pose.pose.orientation.z = quaternion_xyzw[2];
  m.pose.pose.orientation.w = quaternion_xyzw[3];
  std::copy(covariance.begin(), covariance.end(), m.pose.covariance.begin());
  impl_->write(topic, stamp_s, m);
}

void BagWriter::transform(const std::string& topic, double stamp_s, const std::string& parent,
                          const std::string& child, const std::array<double, 3>& position,
                          const std::array<double, 4>& quaternion_xyzw) {
  geometry_msgs::TransformStamped t;
  t.header.stamp = ros::Time(stamp_s);
  t.header.frame_id = parent;
  t.child_frame_id = child;
  t.transform.translation.x = position[0];
  t.transform.translation.y = position[1];
  t.transform.translation.z = position[2];
  t.transform.rotation.x = quaternion_xyzw[0];
  t.transform.rotation.y = quaternion_xyzw[1];
  t.transform.rotation.z = quaternion_xyzw[2];
  t.transform.rotation.w = quaternion_xyzw[3];
  tf2_msgs::TFMessage m;
  m.transforms.push_back(t);
  impl_->write(topic, stamp_s, m);
}

}  // namespace dynemo::test
