#include "generated_rawlog.h"

#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/io/CFileOutputStream.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/serialization/CArchive.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <opencv2/core.hpp>
#include <stdexcept>

#include "dynemo/core/mrpt_conversions.h"
#include "dynemo/core/noise.h"

namespace dynemo::test {
namespace {

constexpr std::int64_t kBeginning_s = 1'700'000'000;
constexpr int kWidth = 64, kHeight = 48;

}  // namespace

TemporaryFolder::TemporaryFolder() {
  std::string pattern = (fs::temp_directory_path() / "dynemo_ingest_XXXXXX").string();
  if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("no temporary folder");
  path_ = pattern;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

RawlogWriter::RawlogWriter(const fs::path& file, bool compressed) {
  if (compressed)
    stream_ = std::make_unique<mrpt::io::CFileGZOutputStream>(file.string());
  else
    stream_ = std::make_unique<mrpt::io::CFileOutputStream>(file.string());
}

void RawlogWriter::write(const mrpt::serialization::CSerializable& object) {
  mrpt::serialization::archiveFrom(*stream_).WriteObject(object);
}

void RawlogWriter::writeNull() { mrpt::serialization::archiveFrom(*stream_).WriteObject(nullptr); }

void RawlogWriter::writeBytes(const std::string& bytes) {
  stream_->Write(bytes.data(), bytes.size());
}

Stamp at(double seconds) {
  // Whole 100 ns, the resolution of MRPT's clock.
  return {kBeginning_s * 1'000'000'000 + std::llround(seconds * 1e7) * 100};
}

mrpt::Clock::time_point mrptTime(double seconds) { return toMrpt(at(seconds)); }

Pose3 truePose(double seconds) {
  const double angle = 0.2 * seconds;
  return Pose3::fromYawPitchRoll(5.0 * std::sin(angle), 5.0 - 5.0 * std::cos(angle),
                                 0.05 * std::sin(seconds), angle, 0.01, -0.02);
}

mrpt::obs::CObservationPointCloud cloudObservation(double seconds, std::size_t points,
                                                   const std::string& label) {
  mrpt::obs::CObservationPointCloud o;
  o.timestamp = mrptTime(seconds);
  o.sensorLabel = label;
  o.sensorPose = toMrpt(kBaseFromLidar);
  auto map = mrpt::maps::CSimplePointsMap::Create();
  for (std::size_t i = 0; i < points; ++i) {
    const double a = 0.1 * static_cast<double>(i), b = 0.37 * std::sin(a * 0.7);
    map->insertPoint(static_cast<float>(5 * std::cos(a) * std::cos(b)),
                     static_cast<float>(5 * std::sin(a) * std::cos(b)),
                     static_cast<float>(5 * std::sin(b)));
  }
  o.pointcloud = map;
  return o;
}

mrpt::obs::CObservationImage imageObservation(double seconds, const std::string& label,
                                              int channels) {
  mrpt::obs::CObservationImage o;
  o.timestamp = mrptTime(seconds);
  o.sensorLabel = label;
  o.cameraPose = toMrpt(kBaseFromCamera);
  o.cameraParams.ncols = kWidth;
  o.cameraParams.nrows = kHeight;
  o.cameraParams.setIntrinsicParamsFromValues(60, 61, 31.5, 23.5);
  o.cameraParams.setDistortionPlumbBob(0.1, -0.2, 0.001, 0.002, 0.05);
  cv::Mat pixels(kHeight, kWidth, channels == 1 ? CV_8UC1 : CV_8UC3);
  for (int r = 0; r < kHeight; ++r)
    for (int c = 0; c < kWidth; ++c) {
      const auto value = static_cast<std::uint8_t>(2 * r + 2 * c);
      if (channels == 1)
        pixels.at<std::uint8_t>(r, c) = value;
      else
        pixels.at<cv::Vec3b>(r, c) = {value, value, value};
    }
  o.image = mrpt::img::CImage(pixels, mrpt::img::DEEP_COPY);
  return o;
}

mrpt::obs::CObservationRobotPose poseObservation(double seconds, const std::string& label) {
  mrpt::obs::CObservationRobotPose o;
  o.timestamp = mrptTime(seconds);
  o.sensorLabel = label;
  o.pose = toMrptGaussian(truePose(seconds), isotropicCovariance(0.1 + 0.01 * seconds, 0.02));
  return o;
}

mrpt::obs::CObservationOdometry odometryObservation(double seconds, const std::string& label) {
  mrpt::obs::CObservationOdometry o;
  o.timestamp = mrptTime(seconds);
  o.sensorLabel = label;
  o.odometry = mrpt::poses::CPose2D(toMrpt(truePose(seconds)));
  return o;
}

mrpt::obs::CObservation6DFeatures featuresObservation(double seconds, int id,
                                                      const Pose3& T_sensor_entity,
                                                      const std::string& label) {
  mrpt::obs::CObservation6DFeatures o;
  o.timestamp = mrptTime(seconds);
  o.sensorLabel = label;
  o.sensorPose = toMrpt(kBaseFromCamera);
  auto& feature = o.sensedFeatures.emplace_back();
  feature.id = id;
  feature.pose = toMrpt(T_sensor_entity);
  return o;
}

void writeLog(const fs::path& file, const LogShape& shape) {
  RawlogWriter out(file, shape.compressed);
  const int ticks = static_cast<int>(std::llround(shape.duration_s * 1000));
  const auto due = [](int tick, double period_s) {
    return period_s > 0 && tick % static_cast<int>(std::llround(period_s * 1000)) == 0;
  };
  for (int tick = 0; tick <= ticks; ++tick) {
    const double t = 0.001 * tick;
    if (due(tick, shape.odometry_period_s)) out.write(poseObservation(t));
    if (due(tick, shape.scan_period_s)) out.write(cloudObservation(t, shape.points));
    if (due(tick, shape.image_period_s)) out.write(imageObservation(t));
  }
}

std::vector<SensorFrame> allFrames(FrameSource& source) {
  std::vector<SensorFrame> frames;
  while (auto frame = source.next()) frames.push_back(std::move(*frame));
  return frames;
}

std::uint64_t warningCount(const IngestReport& report, const std::string& part) {
  std::uint64_t sum = 0;
  for (const auto& [what, times] : report.warnings)
    if (what.find(part) != std::string::npos) sum += times;
  return sum;
}

std::string readBytes(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

void writeFile(const fs::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

}  // namespace dynemo::test
