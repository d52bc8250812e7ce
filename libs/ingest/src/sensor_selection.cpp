#include "dynemo/ingest/sensor_selection.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "dynemo/core/error.h"

namespace dynemo {
namespace {

std::string list(const std::set<std::string>& labels) {
  std::string text;
  for (const std::string& label : labels) text += (text.empty() ? "'" : ", '") + label + "'";
  return text;
}

[[noreturn]] void throwAmbiguous(const std::string& origin, const char* what,
                                 const std::set<std::string>& labels, const char* key) {
  throw ConfigError(origin + ": several sensors give " + what + ": " + list(labels) +
                    "; choose one with " + key);
}

bool has(const std::vector<TimedItem>& items, SensorRole role,
         const std::set<std::string>& labels) {
  return std::any_of(items.begin(), items.end(), [&](const TimedItem& item) {
    return item.role == role && (labels.empty() || labels.contains(item.label));
  });
}

}  // namespace

SensorSelection::SensorSelection(const IngestParams& params,
                                 const std::vector<TimedItem>& beginning, bool csv_detections,
                                 const std::string& origin)
    : image_labels_(params.cameras.labels.begin(), params.cameras.labels.end()),
      detection_labels_(params.detections.labels.begin(), params.detections.labels.end()) {
  for (const std::string& label : image_labels_) named_.insert({SensorRole::kImage, label});
  for (const std::string& label : detection_labels_) named_.insert({SensorRole::kDetection, label});
  chooseScans(params, beginning, origin);
  chooseImages(beginning);
  findOtherClocks(params, beginning);
  chooseOdometry(params, beginning, origin);
  if (scan_label_)
    key_ = SensorRole::kScan;
  else if (has(beginning, SensorRole::kImage, image_labels_))
    key_ = SensorRole::kImage;
  else if (csv_detections || has(beginning, SensorRole::kDetection, detection_labels_))
    key_ = SensorRole::kDetection;
}

void SensorSelection::chooseScans(const IngestParams& params,
                                  const std::vector<TimedItem>& beginning,
                                  const std::string& origin) {
  if (!params.lidar.label.empty()) {
    scan_label_ = params.lidar.label;
    named_.insert({SensorRole::kScan, *scan_label_});
    return;
  }
  std::set<std::string> labels;
  for (const TimedItem& item : beginning)
    if (item.role == SensorRole::kScan) labels.insert(item.label);
  if (labels.size() > 1) throwAmbiguous(origin, "scans", labels, "sensors.lidar.label");
  if (!labels.empty()) scan_label_ = *labels.begin();
}

/// Images that come with a depth camera serve when there is no other camera, or when they are asked
/// for by label.
void SensorSelection::chooseImages(const std::vector<TimedItem>& beginning) {
  if (!image_labels_.empty()) return;
  for (const TimedItem& item : beginning)
    if (item.role == SensorRole::kImage && (!image_rank_ || item.rank < *image_rank_))
      image_rank_ = item.rank;
}

/// Odometry none of whose samples comes near the scans that were stored right before and after it.
void SensorSelection::findOtherClocks(const IngestParams& params,
                                      const std::vector<TimedItem>& beginning) {
  // Twice what is ever sorted or interpolated over.
  const double nearest_allowed_s =
      2.0 * std::max(params.sync.sort_window_s, params.odometry.max_gap_s);
  const SensorRole reference = scan_label_ ? SensorRole::kScan : SensorRole::kImage;
  std::map<std::pair<int, std::string>, double> nearest_s;
  const auto compareAlong = [&](auto first, auto last) {
    std::optional<Stamp> frame;
    for (auto it = first; it != last; ++it) {
      if (it->role == reference) frame = it->stamp;
      if (it->role != SensorRole::kOdometry || !frame) continue;
      const double distance_s = std::abs(secondsBetween(*frame, it->stamp));
      const auto [nearest, is_first] = nearest_s.try_emplace({it->rank, it->label}, distance_s);
      nearest->second = std::min(nearest->second, distance_s);
    }
  };
  compareAlong(beginning.begin(), beginning.end());
  compareAlong(beginning.rbegin(), beginning.rend());
  for (const auto& [odometry, distance_s] : nearest_s)
    if (distance_s > nearest_allowed_s) other_clocks_.insert(odometry);
}

void SensorSelection::chooseOdometry(const IngestParams& params,
                                     const std::vector<TimedItem>& beginning,
                                     const std::string& origin) {
  const std::string& wanted = params.odometry.label;
  if (!wanted.empty()) {
    odometry_label_ = wanted;
    named_.insert({SensorRole::kOdometry, wanted});
  }
  std::set<std::string> labels;
  for (const TimedItem& item : beginning) {
    if (item.role != SensorRole::kOdometry || (!wanted.empty() && item.label != wanted)) continue;
    if (isOfOtherClock(item)) continue;
    if (odometry_rank_ && item.rank > *odometry_rank_) continue;
    if (odometry_rank_ && item.rank < *odometry_rank_) labels.clear();
    odometry_rank_ = item.rank;
    labels.insert(item.label);
  }
  if (labels.size() > 1) throwAmbiguous(origin, "odometry", labels, "sensors.odometry.label");
  if (!labels.empty()) odometry_label_ = *labels.begin();
}

bool SensorSelection::uses(const TimedItem& item) const {
  switch (item.role) {
    case SensorRole::kScan:
      return scan_label_ == item.label;
    case SensorRole::kImage:
      return (image_labels_.empty() || image_labels_.contains(item.label)) &&
             (!image_rank_ || image_rank_ == item.rank);
    case SensorRole::kDetection:
      return detection_labels_.empty() || detection_labels_.contains(item.label);
    case SensorRole::kOdometry:
      return odometry_label_ == item.label && (!odometry_rank_ || odometry_rank_ == item.rank) &&
             !isOfOtherClock(item);
  }
  return false;
}

}  // namespace dynemo
