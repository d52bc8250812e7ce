#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "dynemo/ingest/sensor_frame.h"

namespace dynemo {

/// What a source has delivered, skipped and why; complete when next() has returned nothing.
struct IngestReport {
  /// Events by description, e.g. "image without scan within 50 ms", "cloud: NaN points removed".
  std::map<std::string, std::uint64_t> warnings;
  /// Observations read, by "label (class)".
  std::map<std::string, std::uint64_t> observations;
  std::uint64_t frames = 0;
  std::optional<Stamp> first, last;
};

/// How far a source has come, for progress bars: fraction of the input consumed in [0, 1] and
/// dataset seconds.
struct IngestProgress {
  double fraction = 0.0;
  double dataset_s = 0.0;
};

class FrameSource {
 public:
  virtual ~FrameSource() = default;
  /// The next frame in order of time, or nothing at the end. Throws DataError on input that cannot
  /// be used at all; damage after a usable beginning ends the stream with a counted warning.
  virtual std::optional<SensorFrame> next() = 0;
  /// Whether the frames carry the log's odometry (where it has no gap).
  virtual bool hasOdometry() const = 0;
  virtual const IngestReport& report() const = 0;
  virtual IngestProgress progress() const = 0;
};

}  // namespace dynemo
