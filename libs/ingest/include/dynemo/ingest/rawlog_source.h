// Frames from an MRPT rawlog and, optionally, a table of entity detections.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "dynemo/ingest/frame_source.h"
#include "dynemo/ingest/ingest_params.h"

namespace dynemo {

/// Streams a rawlog of either format, compressed or not, as synchronised frames; `detections_csv`
/// is read as detections_csv.h says. At least one of the two must be given.
///
/// Frames follow the scans when there is a LiDAR, else the images, else the detections, else the
/// odometry; which sensors there are is decided from the beginning of the log
/// (SyncParams::probe_s). Throws ConfigError when a choice is left open (several LiDARs, several
/// odometries) or a parameter is wrong, and DataError when the input gives nothing usable.
std::unique_ptr<FrameSource> makeRawlogSource(
    const IngestParams& params, const std::optional<std::filesystem::path>& rawlog,
    const std::optional<std::filesystem::path>& detections_csv = std::nullopt);

}  // namespace dynemo
