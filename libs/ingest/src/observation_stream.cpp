#include "dynemo/ingest/observation_stream.h"

#include "action_odometry.h"
#include "dynemo/core/mrpt_conversions.h"

namespace dynemo {
namespace {

std::string labelText(const std::string& label) {
  return label.empty() ? "(no label)" : "'" + label + "'";
}

}  // namespace

ObservationStream::ObservationStream(const std::filesystem::path& rawlog,
                                     const DecodeContext& context)
    : context_(context),
      reader_(rawlog, static_cast<std::size_t>(context.params.max_object_mb * 1e6)),
      action_odometry_(std::make_unique<ActionOdometry>()) {}

ObservationStream::~ObservationStream() = default;

std::optional<TimedItem> ObservationStream::next() {
  while (ready_.empty()) {
    const auto entry = reader_.next();
    if (!entry) {
      flushPendingAction();
      break;
    }
    take(*entry);
  }
  if (ready_.empty()) return std::nullopt;
  TimedItem item = std::move(ready_.front());
  ready_.pop_front();
  return item;
}

void ObservationStream::take(const RawlogEntry& entry) {
  using Kind = RawlogEntry::Kind;
  switch (entry.kind) {
    case Kind::kObservation:
      return takeObservation(std::dynamic_pointer_cast<mrpt::obs::CObservation>(entry.object));
    case Kind::kSensoryFrame:
      return takeFrame(dynamic_cast<const mrpt::obs::CSensoryFrame&>(*entry.object));
    case Kind::kActions:
      return takeActions(dynamic_cast<const mrpt::obs::CActionCollection&>(*entry.object));
    case Kind::kNull:
      return context_.warnings.count("stored null object skipped");
    case Kind::kOther:
      return context_.warnings.count("object of class " + entry.class_name + " skipped");
  }
}

void ObservationStream::takeObservation(const mrpt::obs::CObservation::Ptr& observation) {
  if (!observation) return context_.warnings.count("stored null object skipped");
  const std::string& label = observation->sensorLabel;
  ++observations_[(label.empty() ? "(no label)" : label) + " (" + shortClassName(*observation) +
                  ")"];
  const Decoders& known = decoders();
  const int scan = known.scans.find(*observation), image = known.images.find(*observation);
  const int odometry = known.odometry.find(*observation);
  const int detections = known.detections.find(*observation);
  if (scan < 0 && image < 0 && odometry < 0 && detections < 0) return;

  const auto stamp = validStamp(observation->timestamp);
  if (!stamp)
    return context_.warnings.count("observation of " + labelText(label) +
                                   " without valid time stamp");
  if (odometry < 0) {
    const auto pose = sensorPose(*observation, context_);
    if (pose) sensor_poses_[label] = *pose;
  }
  if (scan >= 0) ready_.push_back({*stamp, SensorRole::kScan, label, scan, observation});
  if (image >= 0) ready_.push_back({*stamp, SensorRole::kImage, label, image, observation});
  if (odometry >= 0) takeOdometry(*observation, *stamp, odometry);
  if (detections >= 0) takeDetections(*observation, *stamp);
}

void ObservationStream::takeOdometry(mrpt::obs::CObservation& observation, Stamp stamp, int rank) {
  const auto& decode = decoders().odometry.entries()[static_cast<std::size_t>(rank)].decode;
  auto state = decode(observation, context_);
  if (!state)
    return context_.warnings.count("odometry of " + labelText(observation.sensorLabel) + ": " +
                                   state.error().what);
  ready_.push_back({stamp, SensorRole::kOdometry, observation.sensorLabel, rank, *state});
}

void ObservationStream::takeDetections(mrpt::obs::CObservation& observation, Stamp stamp) {
  const auto& table = decoders().detections;
  const auto rank = table.find(observation);
  auto found = table.entries()[static_cast<std::size_t>(rank)].decode(observation, context_);
  if (!found)
    return context_.warnings.count("detections of " + labelText(observation.sensorLabel) + ": " +
                                   found.error().what);
  for (ExternalDetection& d : *found) {
    d.stamp = stamp;
    ready_.push_back({stamp, SensorRole::kDetection, observation.sensorLabel, rank, std::move(d)});
  }
}

void ObservationStream::takeFrame(const mrpt::obs::CSensoryFrame& frame) {
  std::optional<Stamp> stamp;
  for (const auto& observation : frame)
    if (!stamp && observation) stamp = validStamp(observation->timestamp);
  last_frame_stamp_ = stamp;
  if (actions_seen_ && stamp) {
    emitActionOdometry(*stamp);
    action_pending_ = false;
  }
  flushPendingAction();
  for (const auto& observation : frame) takeObservation(observation);
}

void ObservationStream::takeActions(const mrpt::obs::CActionCollection& actions) {
  flushPendingAction();
  // The first frame may come before the first action: the odometry starts there.
  if (!actions_seen_ && last_frame_stamp_) emitActionOdometry(*last_frame_stamp_);
  if (!action_odometry_->apply(actions, context_.warnings)) return;
  actions_seen_ = action_pending_ = true;
  action_stamp_.reset();
  for (const auto& action : actions)
    if (!action_stamp_ && action.get_ptr()) action_stamp_ = validStamp(action.get_ptr()->timestamp);
}

void ObservationStream::emitActionOdometry(Stamp stamp) {
  const int rank = static_cast<int>(decoders().odometry.entries().size());
  ready_.push_back({stamp, SensorRole::kOdometry, kActionsLabel, rank, action_odometry_->state()});
}

void ObservationStream::flushPendingAction() {
  if (action_pending_ && action_stamp_) emitActionOdometry(*action_stamp_);
  if (action_pending_ && !action_stamp_)
    context_.warnings.count("odometry action without time stamp and without sensory frame");
  action_pending_ = false;
}

}  // namespace dynemo
