// Groups a time-ordered stream of observations into frames.
#pragma once

#include <deque>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dynemo/ingest/ingest_params.h"
#include "dynemo/ingest/odometry_buffer.h"
#include "dynemo/ingest/timed_item.h"
#include "dynemo/ingest/warning_counter.h"

namespace dynemo {

/// What belongs together, not decoded yet.
struct FrameDraft {
  Stamp stamp;
  std::optional<TimedItem> scan;
  std::vector<TimedItem> images;
  std::vector<TimedItem> detections;
  /// Interpolated to the frame's stamp, to each image's and to each detection's.
  std::optional<OdometryState> odometry;
  std::vector<std::optional<OdometryState>> image_odometry, detection_odometry;
};

/// Frames follow the items of the key role. Of every other stream (a camera; one entity as seen by
/// one detector) the item nearest to the frame joins it when it is at most max_image_offset_s away
/// and not nearer to the next frame; each item is used once. Images as key: the earliest unused
/// image opens a frame and the other cameras' join it. Detections as key: a frame is made of those
/// with equal stamps. Stamps of frames strictly increase.
class Synchronizer {
 public:
  Synchronizer(const SyncParams& sync, const OdometrySensorParams& odometry, SensorRole key,
               WarningCounter& warnings);

  /// Stamps must not decrease.
  void push(TimedItem item);
  /// No further item comes.
  void finish() { finished_ = true; }
  /// The next frame that nothing to come can change.
  std::optional<FrameDraft> pop();

 private:
  /// One camera, or one entity of one detector.
  using Stream = std::pair<SensorRole, std::string>;
  struct Queue {
    std::deque<TimedItem> items;
    std::optional<Stamp> last;
  };

  bool isKey(const Stream& stream) const { return stream.first == key_; }
  std::optional<std::pair<Stream, Stamp>> nextKey() const;
  std::optional<Stamp> keyAfter(const Stream& stream) const;
  bool isSettled(Stamp frame) const;
  FrameDraft draft(const Stream& key_stream, Stamp stamp);
  std::optional<TimedItem> takeNearest(const Stream& stream, Queue& queue, Stamp frame,
                                       std::optional<Stamp> next_frame);
  void dropOlderThan(Stamp limit);
  void interpolateOdometry(FrameDraft& frame);
  std::optional<OdometryState> odometryAt(Stamp stamp, const char* of_what);
  std::optional<FrameDraft> popOdometryFrame();
  Stamp before(Stamp stamp, double seconds) const;

  SyncParams params_;
  SensorRole key_;
  WarningCounter& warnings_;
  double horizon_s_;
  std::map<Stream, Queue> queues_;
  OdometryBuffer odometry_;
  std::deque<std::pair<Stamp, OdometryState>> odometry_frames_;
  std::optional<Stamp> now_, last_frame_;
  bool finished_ = false;
  bool has_odometry_ = false;
};

}  // namespace dynemo
