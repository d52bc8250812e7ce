// Small ROS 1 bags for tests. As bag_reader.h, this may need no more than C++17.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace dynemo::test {

class BagWriter {
 public:
  explicit BagWriter(const std::string& file);
  ~BagWriter();
  BagWriter(const BagWriter&) = delete;
  BagWriter& operator=(const BagWriter&) = delete;

  /// Points of x y z and, when given, a time and intensity, with unused bytes between.
  void cloud(const std::string& topic, double stamp_s, const std::string& frame,
             const std::vector<std::array<float, 3>>& points, const std::vector<float>& intensities,
             const char* time_field = nullptr);
  void image(const std::string& topic, double stamp_s, const std::string& frame,
             const std::string& encoding, std::uint32_t width, std::uint32_t height,
             const std::vector<std::uint8_t>& data);
  void compressedImage(const std::string& topic, double stamp_s, const std::string& frame,
                       const std::vector<std::uint8_t>& data);
  void cameraInfo(const std::string& topic, double stamp_s, std::uint32_t width,
                  std::uint32_t height, const std::string& model, const std::vector<double>& D);
  void odometry(const std::string& topic, double stamp_s, const std::string& child,
                const std::array<double, 3>& position, const std::array<double, 4>& quaternion_xyzw,
                const std::array<double, 36>& covariance);
  void transform(const std::string& topic, double stamp_s, const std::string& parent,
                 const std::string& child, const std::array<double, 3>& position,
                 const std::array<double, 4>& quaternion_xyzw);

 private:
  struct Impl;
  Impl* impl_;
};

}  // namespace dynemo::test
