// From rawlogs to rawlogs: cut, thin, join, and correct what a recording says about its sensors.
//
// Everything streams, keeps both formats of rawlogs and their compression, copies what is not
// changed byte by byte, takes external images along, never touches the input, and shows a result
// only when it is complete. RawlogOutput says which errors are thrown.
#pragma once

#include <mrpt/img/TCamera.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "dynemo/core/se3.h"
#include "dynemo/prep/rawlog_output.h"

namespace dynemo {

struct RewriteReport {
  std::uint64_t read = 0;  ///< objects
  std::uint64_t written = 0;
  /// Observations that were changed, by label.
  std::map<std::string, std::uint64_t> edited;
  std::map<std::string, std::uint64_t> warnings;
  std::vector<std::filesystem::path> files;
};

struct RewriteOptions {
  ImageTransfer images = ImageTransfer::kCopy;
  /// Compress the result; empty: as the (first) input is.
  std::optional<bool> compressed{};
};

/// Times of a cut: seconds after the first stamp of the log, or UNIX seconds.
struct TimeRange {
  std::optional<double> from_s{}, to_s{};
  bool unix_time = false;
};

/// Keeps what lies in [from, to). Throws DataError when nothing does, and ConfigError when `to` is
/// not after `from`.
RewriteReport trimRawlog(const std::filesystem::path& input, const std::filesystem::path& output,
                         const TimeRange& range, const RewriteOptions& options);

/// Parts of `duration_s` each: STEM_01.rawlog, STEM_02.rawlog, … for an output STEM.rawlog. Parts
/// without an observation are left out. Throws ConfigError when there would be more than 500.
RewriteReport splitRawlog(const std::filesystem::path& input, const std::filesystem::path& output,
                          double duration_s, const RewriteOptions& options);

struct Decimation {
  /// Sensors to thin; empty: all.
  std::set<std::string> labels{};
  /// Keep the first of every n observations of a sensor …
  std::uint64_t keep_every = 1;
  /// … and the first of every n points of a cloud.
  std::uint64_t keep_points_every = 1;
};
/// Throws ConfigError when a label does not occur, or both numbers are 1.
RewriteReport decimateRawlog(const std::filesystem::path& input,
                             const std::filesystem::path& output, const Decimation& decimation,
                             const RewriteOptions& options);

/// One log in the order of time of logs that are each in order of time. Throws DataError when one
/// of them has actions and sensory frames, whose order is not one of time.
RewriteReport mergeRawlogs(const std::vector<std::filesystem::path>& inputs,
                           const std::filesystem::path& output, const RewriteOptions& options);

/// Sets T_base_sensor by sensor label. Throws ConfigError, listing the labels of the log, when one
/// does not occur.
RewriteReport setExtrinsics(const std::filesystem::path& input, const std::filesystem::path& output,
                            const std::map<std::string, Pose3>& T_base_sensor,
                            const RewriteOptions& options);

/// Reads the intrinsics of a camera as ROS' camera_calibration and MRPT write them (image_width,
/// camera_matrix, distortion_model, distortion_coefficients, …). Throws ConfigError.
mrpt::img::TCamera readCalibration(const std::filesystem::path& yaml_file);

/// Sets the intrinsics of the images of one sensor. Images whose own size is known and differs are
/// counted in the warnings.
RewriteReport setCalibration(const std::filesystem::path& input,
                             const std::filesystem::path& output, const std::string& label,
                             const mrpt::img::TCamera& calibration, const RewriteOptions& options);

struct LabelChange {
  std::string from{}, to{};
  /// Only observations of this class; empty: all.
  std::string class_name{};
};
/// Whether sensors of different labels may end up with the same one.
enum class SameLabel { kRefuse, kMerge };
/// Throws ConfigError when a change applies to nothing, and when sensors that had different labels
/// would have one, which nothing could tell apart afterwards, unless that is wanted.
RewriteReport relabelRawlog(const std::filesystem::path& input, const std::filesystem::path& output,
                            const std::vector<LabelChange>& changes, SameLabel same_label,
                            const RewriteOptions& options);

enum class ImageFormat { kPng, kJpeg };
/// Puts the images that are stored inside of the log (of CObservationImage and
/// CObservationStereoImages) into files. Throws DataError when the log has no image at all.
RewriteReport externalizeImages(const std::filesystem::path& input,
                                const std::filesystem::path& output, ImageFormat format,
                                int jpeg_quality, const RewriteOptions& options);

}  // namespace dynemo
