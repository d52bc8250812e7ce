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

enum class KittiImages {
  kRectified,   ///< without lens distortion, as KITTI's are: calib.txt describes them wholly
  kAsRecorded,  ///< with it
};

struct KittiReport {
  std::uint64_t clouds = 0, images = 0, poses = 0;
  /// Images whose lens distortion was taken out.
  std::uint64_t rectified = 0;
  std::map<std::string, std::uint64_t> warnings;
};

/// Writes a sequence as the KITTI odometry benchmark lays it out:
///   velodyne/000000.bin   x y z reflectance (0), float32, in the LiDAR's frame
///   image_0/000000.png    grey images of the first camera by label; image_1, … the others'
///   times.txt             seconds after the first frame;  stamps.txt: UNIX time, nine digits
///   calib.txt             P0, P1, … (3×4, pixels) and Tr: LiDAR to the first camera
///   calib_cam_to_cam.txt  of each camera as recorded, as in KITTI's raw data: S_00 (size), K_00
///                         (3×3), D_00 (distortion: k1 k2 p1 p2 k3 …)
///   poses.txt             3×4 rows: the first camera (without one: the LiDAR) in the frame of
///                         its first pose, by the log's odometry; absent when it has none
/// One number per frame that dynemo-slam would see. Rectified images have the focal lengths, the
/// principal point and the size of the recorded ones; what lay outside of those is black. Images as
/// recorded that have distortion, which calib.txt cannot say, and D of fisheye lenses (Kannala-
/// Brandt, k1 … k4), which is not KITTI's, are counted in the warnings. `folder` appears when it is
/// complete. Throws DataError when it exists or cannot be written, or when the log has neither
/// scans nor images, and ConfigError for a choice left open.
KittiReport exportKitti(const std::filesystem::path& rawlog, const std::filesystem::path& folder,
                        const IngestParams& params, KittiImages images = KittiImages::kRectified);

}  // namespace dynemo
