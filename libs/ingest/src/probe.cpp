#include "probe.h"

#include <algorithm>
#include <map>
#include <utility>

namespace dynemo {
namespace {

constexpr std::size_t kMostScansAndImages = 100;
constexpr std::size_t kMostItems = 20000;
/// A longer step between two observations of a sensor counts as this much: a single wrong stamp
/// must not end the probe.
constexpr double kLongestStep_s = 1.0;

/// How long each sensor has been running.
class Coverage {
 public:
  double add(const TimedItem& item) {
    auto& [last, total_s] = by_sensor_[{item.role, item.label}];
    if (last) total_s += std::clamp(secondsBetween(*last, item.stamp), 0.0, kLongestStep_s);
    last = item.stamp;
    return total_s;
  }

 private:
  std::map<std::pair<SensorRole, std::string>, std::pair<std::optional<Stamp>, double>> by_sensor_;
};

}  // namespace

std::vector<TimedItem> readBeginning(ObservationStream& stream, double duration_s) {
  std::vector<TimedItem> items;
  Coverage coverage;
  bool covered = false, more_than_odometry = false;
  std::size_t scans_and_images = 0;
  while (items.size() < kMostItems && scans_and_images < kMostScansAndImages &&
         !(covered && more_than_odometry)) {
    auto item = stream.next();
    if (!item) break;
    covered = covered || coverage.add(*item) >= duration_s;
    more_than_odometry = more_than_odometry || item->role != SensorRole::kOdometry;
    if (item->role == SensorRole::kScan || item->role == SensorRole::kImage) ++scans_and_images;
    items.push_back(std::move(*item));
  }
  return items;
}

}  // namespace dynemo
