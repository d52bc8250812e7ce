#include "dynemo/ingest/synchronizer.h"

#include <algorithm>
#include <cmath>

namespace dynemo {
namespace {

/// More frames than this waiting means that time does not progress; the oldest is then let go.
constexpr std::size_t kMostWaiting = 256;

std::string streamName(const TimedItem& item) {
  if (const auto* detection = std::get_if<ExternalDetection>(&item.payload))
    return item.label + "#" + std::to_string(detection->entity.value);
  return item.label;
}

const char* nameOf(SensorRole role) {
  switch (role) {
    case SensorRole::kScan:
      return "scan";
    case SensorRole::kImage:
      return "image";
    case SensorRole::kDetection:
      return "detection";
    case SensorRole::kOdometry:
      return "odometry";
  }
  return "";
}

double distance(Stamp a, Stamp b) { return std::abs(secondsBetween(a, b)); }

}  // namespace

Synchronizer::Synchronizer(const SyncParams& sync, const OdometrySensorParams& odometry,
                           SensorRole key, WarningCounter& warnings)
    : params_(sync),
      key_(key),
      warnings_(warnings),
      // A frame's images lie within one offset of it; whether the next frame is nearer shows one
      // offset later.
      horizon_s_(
          std::max(2.0 * sync.max_image_offset_s, sync.max_image_offset_s + odometry.max_gap_s)),
      odometry_(odometry) {}

void Synchronizer::push(TimedItem item) {
  now_ = item.stamp;
  if (item.role == SensorRole::kOdometry) {
    has_odometry_ = true;
    const auto& state = std::get<OdometryState>(item.payload);
    if (!odometry_.push(item.stamp, state))
      warnings_.count("odometry with a repeated stamp dropped");
    else if (key_ == SensorRole::kOdometry)
      odometry_frames_.emplace_back(item.stamp, state);
    return;
  }
  Queue& queue = queues_[{item.role, streamName(item)}];
  if (queue.last && item.stamp <= *queue.last) {
    warnings_.count(std::string(nameOf(item.role)) + " with a repeated stamp dropped");
    return;
  }
  queue.last = item.stamp;
  queue.items.push_back(std::move(item));
}

std::optional<std::pair<Synchronizer::Stream, Stamp>> Synchronizer::nextKey() const {
  std::optional<std::pair<Stream, Stamp>> first;
  for (const auto& [stream, queue] : queues_) {
    if (!isKey(stream) || queue.items.empty()) continue;
    const Stamp stamp = queue.items.front().stamp;
    if (!first || stamp < first->second) first = {stream, stamp};
  }
  return first;
}

std::optional<Stamp> Synchronizer::keyAfter(const Stream& stream) const {
  const auto& items = queues_.at(stream).items;
  if (items.size() < 2) return std::nullopt;
  return items[1].stamp;
}

bool Synchronizer::isSettled(Stamp frame) const {
  return finished_ || (now_ && secondsBetween(frame, *now_) > horizon_s_);
}

Stamp Synchronizer::before(Stamp stamp, double seconds) const {
  return {stamp.ns - std::llround(seconds * 1e9)};
}

std::optional<FrameDraft> Synchronizer::pop() {
  if (key_ == SensorRole::kOdometry) return popOdometryFrame();
  while (const auto key = nextKey()) {
    const auto& [stream, stamp] = *key;
    const bool waits_too_long = queues_.at(stream).items.size() > kMostWaiting;
    if (!isSettled(stamp) && !waits_too_long) return std::nullopt;
    if (last_frame_ && stamp <= *last_frame_) {
      warnings_.count(std::string(nameOf(key_)) + " not later than the last frame dropped");
      queues_[stream].items.pop_front();
      continue;
    }
    FrameDraft frame = draft(stream, stamp);
    interpolateOdometry(frame);
    last_frame_ = stamp;
    return frame;
  }
  // Without a frame in sight nothing old can be of use any more.
  if (now_) {
    dropOlderThan(finished_ ? Stamp{now_->ns + 1} : before(*now_, horizon_s_));
    odometry_.forgetBefore(before(*now_, horizon_s_ + params_.max_image_offset_s));
  }
  return std::nullopt;
}

FrameDraft Synchronizer::draft(const Stream& key_stream, Stamp stamp) {
  const auto next = keyAfter(key_stream);
  dropOlderThan(before(stamp, params_.max_image_offset_s));
  FrameDraft frame;
  frame.stamp = stamp;
  for (auto& [stream, queue] : queues_) {
    std::optional<TimedItem> item;
    if (stream == key_stream) {
      item = std::move(queue.items.front());
      queue.items.pop_front();
    } else if (key_ == SensorRole::kDetection) {
      if (!queue.items.empty() && queue.items.front().stamp == stamp) {
        item = std::move(queue.items.front());
        queue.items.pop_front();
      }
    } else {
      item = takeNearest(stream, queue, stamp, next);
    }
    if (!item) continue;
    if (stream.first == SensorRole::kScan) frame.scan = std::move(item);
    if (stream.first == SensorRole::kImage) frame.images.push_back(std::move(*item));
    if (stream.first == SensorRole::kDetection) frame.detections.push_back(std::move(*item));
  }
  return frame;
}

std::optional<TimedItem> Synchronizer::takeNearest(const Stream& stream, Queue& queue, Stamp frame,
                                                   std::optional<Stamp> next_frame) {
  auto& items = queue.items;
  auto best = items.end();
  for (auto it = items.begin(); it != items.end(); ++it) {
    const double offset_s = distance(it->stamp, frame);
    if (offset_s > params_.max_image_offset_s) continue;
    if (next_frame && distance(it->stamp, *next_frame) < offset_s) break;
    if (best == items.end() || offset_s < distance(best->stamp, frame)) best = it;
  }
  if (best == items.end()) return std::nullopt;
  TimedItem chosen = std::move(*best);
  // What lies before the chosen one is nearer to no later frame.
  if (!isKey(stream))
    warnings_.count(std::string(nameOf(stream.first)) + " of '" + chosen.label +
                        "' not used: another one was nearer to the frame",
                    static_cast<std::uint64_t>(best - items.begin()));
  if (!isKey(stream))
    items.erase(items.begin(), best + 1);
  else
    items.erase(best);
  return chosen;
}

void Synchronizer::dropOlderThan(Stamp limit) {
  for (auto& [stream, queue] : queues_) {
    if (isKey(stream)) continue;
    while (!queue.items.empty() && queue.items.front().stamp < limit) {
      warnings_.count(std::string(nameOf(stream.first)) + " of '" + queue.items.front().label +
                      "' without a frame close enough");
      queue.items.pop_front();
    }
  }
}

std::optional<OdometryState> Synchronizer::odometryAt(Stamp stamp, const char* of_what) {
  auto state = odometry_.at(stamp);
  if (!state && has_odometry_)
    warnings_.count(std::string(of_what) + " without odometry at its stamp");
  return state;
}

void Synchronizer::interpolateOdometry(FrameDraft& frame) {
  frame.odometry = odometryAt(frame.stamp, "frame");
  for (const TimedItem& image : frame.images)
    frame.image_odometry.push_back(odometryAt(image.stamp, "image"));
  for (const TimedItem& detection : frame.detections)
    frame.detection_odometry.push_back(odometryAt(detection.stamp, "detection"));
  odometry_.forgetBefore(before(frame.stamp, params_.max_image_offset_s));
}

std::optional<FrameDraft> Synchronizer::popOdometryFrame() {
  if (odometry_frames_.empty()) return std::nullopt;
  FrameDraft frame;
  frame.stamp = odometry_frames_.front().first;
  frame.odometry = odometry_frames_.front().second;
  odometry_frames_.pop_front();
  odometry_.forgetBefore(frame.stamp);
  return frame;
}

}  // namespace dynemo
