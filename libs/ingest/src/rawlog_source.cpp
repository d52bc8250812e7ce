#include "dynemo/ingest/rawlog_source.h"

#include <algorithm>
#include <deque>

#include "dynemo/core/error.h"
#include "dynemo/ingest/detections_csv.h"
#include "dynemo/ingest/observation_stream.h"
#include "dynemo/ingest/sensor_selection.h"
#include "dynemo/ingest/synchronizer.h"
#include "dynemo/ingest/time_order.h"
#include "probe.h"

namespace dynemo {
namespace {

namespace fs = std::filesystem;

class RawlogFrameSource : public FrameSource {
 public:
  RawlogFrameSource(const IngestParams& params, const std::optional<fs::path>& rawlog,
                    const std::optional<fs::path>& detections_csv);

  std::optional<SensorFrame> next() override;
  bool hasOdometry() const override { return selection_->hasOdometry(); }
  const IngestReport& report() const override;
  IngestProgress progress() const override;

 private:
  DecodeContext context() { return {params_, extrinsics_, files_, warnings_}; }
  std::optional<TimedItem> read();
  /// Reads on until the synchronizer has something new or the input ends.
  void advance();
  void countNotUsed(const TimedItem& item);
  void endInput();
  void feed(TimedItem item);
  void feedTableUpTo(std::optional<Stamp> stamp);
  const Pose3* sensorPoseOf(const std::string& label) const;
  std::optional<ExternalDetection> resolve(const CsvDetection& row);
  std::optional<SensorFrame> build(FrameDraft draft);
  std::optional<Scan> decodeScan(const TimedItem& item);
  std::optional<CameraImage> decodeImage(const TimedItem& item);
  void checkNothingUsable() const;

  IngestParams params_;
  std::string origin_;
  std::map<std::string, Pose3> extrinsics_;
  ExternalFiles files_;
  WarningCounter warnings_;
  std::vector<CsvDetection> table_;
  std::size_t table_used_ = 0;
  std::unique_ptr<ObservationStream> stream_;
  std::deque<TimedItem> beginning_;
  std::unique_ptr<SensorSelection> selection_;
  TimeOrder order_;
  std::unique_ptr<Synchronizer> synchronizer_;
  std::set<std::pair<SensorRole, std::string>> missing_;
  bool ended_ = false;
  mutable IngestReport report_;
};

RawlogFrameSource::RawlogFrameSource(const IngestParams& params,
                                     const std::optional<fs::path>& rawlog,
                                     const std::optional<fs::path>& detections_csv)
    : params_(params),
      origin_(rawlog ? rawlog->string() : detections_csv->string()),
      extrinsics_(extrinsicsTable(params)),
      order_(params_.sync, params_.clock, warnings_) {
  if (detections_csv) table_ = readDetectionsCsv(*detections_csv, warnings_);
  std::vector<TimedItem> beginning;
  if (rawlog) {
    files_ = ExternalFiles(*rawlog);
    stream_ = std::make_unique<ObservationStream>(*rawlog, context());
    beginning = readBeginning(*stream_, params_.sync.probe_s);
    if (beginning.empty()) checkNothingUsable();
  }
  selection_ = std::make_unique<SensorSelection>(params_, beginning, !table_.empty(), origin_);
  missing_ = selection_->named();
  beginning_.assign(std::make_move_iterator(beginning.begin()),
                    std::make_move_iterator(beginning.end()));
  synchronizer_ =
      std::make_unique<Synchronizer>(params_.sync, params_.odometry, selection_->key(), warnings_);
}

/// A log without a single usable observation is an error, with the reasons.
void RawlogFrameSource::checkNothingUsable() const {
  std::string why;
  if (stream_ && !stream_->reader().damage().empty()) why += "; " + stream_->reader().damage();
  for (const auto& [what, times] : warnings_.counts())
    why += "; " + what + " (" + std::to_string(times) + "x)";
  std::string found;
  if (stream_)
    for (const auto& [what, times] : stream_->observations())
      found += (found.empty() ? "; it holds " : ", ") + std::to_string(times) + " of " + what;
  for (const auto& [role, label] : missing_) why += "; there is no '" + label + "'";
  throw DataError(origin_ + ": no usable scan, image, detection or odometry" + why + found);
}

std::optional<TimedItem> RawlogFrameSource::read() {
  if (!beginning_.empty()) {
    TimedItem item = std::move(beginning_.front());
    beginning_.pop_front();
    return item;
  }
  return stream_ ? stream_->next() : std::nullopt;
}

void RawlogFrameSource::advance() {
  auto item = read();
  if (!item) return endInput();
  missing_.erase({item->role, item->label});
  if (selection_->uses(*item))
    order_.push(std::move(*item));
  else
    countNotUsed(*item);
  while (auto ordered = order_.pop()) feed(std::move(*ordered));
}

void RawlogFrameSource::countNotUsed(const TimedItem& item) {
  if (item.role == SensorRole::kScan) warnings_.count("scan of '" + item.label + "' not used");
  if (item.role != SensorRole::kOdometry || selection_->hasOdometry()) return;
  warnings_.count("odometry of '" + item.label + "' not used: " +
                  (selection_->isOfOtherClock(item)
                       ? "its clock is not that of the other sensors"
                       : "it begins after the time in which sensors are looked for"));
}

void RawlogFrameSource::endInput() {
  ended_ = true;
  order_.finish();
  while (auto ordered = order_.pop()) feed(std::move(*ordered));
  feedTableUpTo(std::nullopt);
  synchronizer_->finish();
  if (stream_ && !stream_->reader().damage().empty())
    warnings_.count("rawlog damaged, the rest is not used: " + stream_->reader().damage());
  for (const auto& [role, label] : missing_)
    warnings_.count("no observation of the configured sensor '" + label + "'");
}

void RawlogFrameSource::feed(TimedItem item) {
  feedTableUpTo(item.stamp);
  if (auto* detection = std::get_if<ExternalDetection>(&item.payload))
    detection->stamp = item.stamp;
  synchronizer_->push(std::move(item));
}

void RawlogFrameSource::feedTableUpTo(std::optional<Stamp> stamp) {
  for (; table_used_ < table_.size(); ++table_used_) {
    const CsvDetection& row = table_[table_used_];
    if (stamp && row.stamp > *stamp) return;
    if (auto detection = resolve(row))
      synchronizer_->push({row.stamp, SensorRole::kDetection, row.sensor_label, 0, *detection});
  }
}

const Pose3* RawlogFrameSource::sensorPoseOf(const std::string& label) const {
  const auto overridden = extrinsics_.find(label);
  if (overridden != extrinsics_.end()) return &overridden->second;
  if (!stream_) return nullptr;
  const auto recorded = stream_->sensorPoses().find(label);
  return recorded == stream_->sensorPoses().end() ? nullptr : &recorded->second;
}

std::optional<ExternalDetection> RawlogFrameSource::resolve(const CsvDetection& row) {
  ExternalDetection d;
  d.stamp = row.stamp;
  d.entity = row.entity;
  d.class_name = row.class_name;
  d.sensor_label = row.sensor_label;
  d.covariance = row.covariance;
  d.T_base_entity = row.T_sensor_entity;
  if (row.sensor_label.empty()) return d;
  const Pose3* T_base_sensor = sensorPoseOf(row.sensor_label);
  if (T_base_sensor == nullptr) {
    warnings_.count("detection of sensor '" + row.sensor_label +
                    "' dropped: neither the log nor sensors.extrinsics has its pose");
    return std::nullopt;
  }
  d.T_base_entity = *T_base_sensor * row.T_sensor_entity;
  return d;
}

std::optional<SensorFrame> RawlogFrameSource::next() {
  while (true) {
    while (auto draft = synchronizer_->pop()) {
      auto frame = build(std::move(*draft));
      if (!frame) continue;
      frame->index = report_.frames++;
      if (!report_.first) report_.first = frame->stamp;
      report_.last = frame->stamp;
      return frame;
    }
    if (ended_) break;
    advance();
  }
  if (report_.frames == 0) checkNothingUsable();
  return std::nullopt;
}

std::optional<SensorFrame> RawlogFrameSource::build(FrameDraft draft) {
  SensorFrame frame;
  frame.stamp = draft.stamp;
  frame.odometry = draft.odometry;
  if (draft.scan) frame.scan = decodeScan(*draft.scan);
  for (std::size_t i = 0; i < draft.images.size(); ++i) {
    auto image = decodeImage(draft.images[i]);
    if (!image) continue;
    image->odometry = draft.image_odometry[i];
    frame.images.push_back(std::move(*image));
  }
  for (std::size_t i = 0; i < draft.detections.size(); ++i) {
    auto& detection = std::get<ExternalDetection>(draft.detections[i].payload);
    detection.odometry = draft.detection_odometry[i];
    frame.detections.push_back(std::move(detection));
  }
  const bool has_data = frame.scan || !frame.images.empty() || !frame.detections.empty();
  if (!has_data && selection_->key() != SensorRole::kOdometry) {
    warnings_.count("frame without any usable data dropped");
    return std::nullopt;
  }
  return frame;
}

std::optional<Scan> RawlogFrameSource::decodeScan(const TimedItem& item) {
  auto& observation = *std::get<mrpt::obs::CObservation::Ptr>(item.payload);
  const auto& entry = decoders().scans.entries()[static_cast<std::size_t>(item.rank)];
  auto scan = entry.decode(observation, context());
  if (!scan) {
    warnings_.count("scan of '" + item.label + "': " + scan.error().what, scan.error().example);
    return std::nullopt;
  }
  scan->stamp = item.stamp;
  return std::move(*scan);
}

std::optional<CameraImage> RawlogFrameSource::decodeImage(const TimedItem& item) {
  auto& observation = *std::get<mrpt::obs::CObservation::Ptr>(item.payload);
  const auto& entry = decoders().images.entries()[static_cast<std::size_t>(item.rank)];
  auto image = entry.decode(observation, context());
  if (!image) {
    warnings_.count("image of '" + item.label + "': " + image.error().what, image.error().example);
    return std::nullopt;
  }
  image->stamp = item.stamp;
  return std::move(*image);
}

const IngestReport& RawlogFrameSource::report() const {
  report_.warnings = warnings_.counts();
  if (stream_) report_.observations = stream_->observations();
  if (!table_.empty()) report_.observations["(detections table)"] = table_.size();
  return report_;
}

IngestProgress RawlogFrameSource::progress() const {
  IngestProgress progress;
  if (stream_)
    progress.fraction = stream_->reader().fractionRead();
  else if (!table_.empty())
    progress.fraction = static_cast<double>(table_used_) / static_cast<double>(table_.size());
  if (report_.first) progress.dataset_s = secondsBetween(*report_.first, *report_.last);
  return progress;
}

}  // namespace

std::unique_ptr<FrameSource> makeRawlogSource(const IngestParams& params,
                                              const std::optional<fs::path>& rawlog,
                                              const std::optional<fs::path>& detections_csv) {
  if (!rawlog && !detections_csv)
    throw ConfigError("neither a rawlog nor a table of detections is given");
  if (params.lidar.min_range_m >= params.lidar.max_range_m)
    throw ConfigError("sensors.lidar.min_range_m must be smaller than max_range_m");
  return std::make_unique<RawlogFrameSource>(params, rawlog, detections_csv);
}

}  // namespace dynemo
