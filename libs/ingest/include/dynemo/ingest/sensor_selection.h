// Which of a log's sensors are used, decided from its beginning.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "dynemo/ingest/ingest_params.h"
#include "dynemo/ingest/timed_item.h"

namespace dynemo {

class SensorSelection {
 public:
  /// Chooses from the labels in `beginning` where the parameters leave it open. `csv_detections`:
  /// there are detections besides the log's. `origin` names the log in messages. Throws ConfigError
  /// when there are several LiDARs or several odometries of the best kind.
  SensorSelection(const IngestParams& params, const std::vector<TimedItem>& beginning,
                  bool csv_detections, const std::string& origin);

  bool uses(const TimedItem& item) const;
  /// Whether this odometry is left out because its stamps come from another clock than the scans'
  /// (without scans: the images'): it tells nothing of the motion between them.
  bool isOfOtherClock(const TimedItem& odometry) const {
    return other_clocks_.contains({odometry.rank, odometry.label});
  }
  /// What the frames follow.
  SensorRole key() const { return key_; }
  /// Whether the beginning of the log carries odometry that is used.
  bool hasOdometry() const { return odometry_rank_.has_value(); }
  /// Labels that the configuration names, with their roles.
  const std::set<std::pair<SensorRole, std::string>>& named() const { return named_; }

 private:
  void chooseScans(const IngestParams& params, const std::vector<TimedItem>& beginning,
                   const std::string& origin);
  void chooseImages(const std::vector<TimedItem>& beginning);
  void findOtherClocks(const IngestParams& params, const std::vector<TimedItem>& beginning);
  void chooseOdometry(const IngestParams& params, const std::vector<TimedItem>& beginning,
                      const std::string& origin);

  std::optional<std::string> scan_label_;
  std::set<std::string> image_labels_, detection_labels_;  ///< empty: all
  std::optional<std::string> odometry_label_;
  std::optional<int> image_rank_, odometry_rank_;       ///< the preferred class; empty: any
  std::set<std::pair<int, std::string>> other_clocks_;  ///< odometries by rank and label
  SensorRole key_ = SensorRole::kOdometry;
  std::set<std::pair<SensorRole, std::string>> named_;
};

}  // namespace dynemo
