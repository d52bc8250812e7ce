// A rawlog as folders of files, as many programs for LiDAR and cameras read them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "dynemo/ingest/ingest_params.h"

namespace dynemo {

struct KittiReport {
  std::uint64_t clouds = 0, images = 0, poses = 0;
  std::map<std::string, std::uint64_t> warnings;
};

/// Writes a sequence as the KITTI odometry benchmark lays it out:
///   velodyne/000000.bin   x y z reflectance (0), float32, in the LiDAR's frame
///   image_0/000000.png    grey images of the first camera by label; image_1, … the others'
///   times.txt             seconds after the first frame;  stamps.txt: UNIX time, nine digits
///   calib.txt             P0, P1, … (3×4, pixels) and Tr: LiDAR to the first camera
///   poses.txt             3×4 rows: the first camera (without one: the LiDAR) in the frame of
///                         its first pose, by the log's odometry; absent when it has none
/// One number per frame that dynemo-slam would see. Images are not undistorted. `folder` appears
/// when it is complete. Throws DataError when it exists or cannot be written, or when the log has
/// neither scans nor images, and ConfigError for a choice left open.
KittiReport exportKitti(const std::filesystem::path& rawlog, const std::filesystem::path& folder,
                        const IngestParams& params);

}  // namespace dynemo
