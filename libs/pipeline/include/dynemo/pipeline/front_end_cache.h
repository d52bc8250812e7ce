// What the front-end found in each frame without looking at the map: LiDAR odometry and entity
// detections. No setup changes it, so one run can record it in a file and the runs of other setups
// replay it, with the same results to the byte.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "dynemo/odometry/scan_odometry.h"
#include "dynemo/perception/entity_detector.h"
#include "dynemo/pipeline/params.h"

namespace dynemo {

class FrontEndCache {
 public:
  /// Replays the file when it is complete and was recorded with the same `identity`; else records
  /// anew, under a temporary name until finish(). Throws DataError when the file can neither be
  /// read nor written.
  FrontEndCache(std::filesystem::path file, const std::string& identity);
  ~FrontEndCache();
  FrontEndCache(const FrontEndCache&) = delete;
  FrontEndCache& operator=(const FrontEndCache&) = delete;

  bool replays() const { return in_.is_open(); }
  /// The same stage with its results recorded or replayed. The cache must outlive it.
  std::unique_ptr<ScanOdometry> wrap(std::unique_ptr<ScanOdometry> odometry);
  std::unique_ptr<EntityDetector> wrap(std::unique_ptr<EntityDetector> detector);
  /// Makes what was recorded available to others; not after an interruption.
  void finish();

 private:
  class Odometry;
  class Detector;
  template <class T>
  void put(const T& value);
  template <class T>
  T get();
  void putText(const std::string& text);
  std::string getText();

  std::filesystem::path file_, temporary_;
  std::ifstream in_;
  std::ofstream out_;
};

/// Everything that the front-end's results depend on: the recording, its entity file, and the
/// parameters of the stages before the map.
std::string frontEndIdentity(const DynemoParams& params, const std::filesystem::path& rawlog,
                             const std::optional<std::filesystem::path>& entities);

}  // namespace dynemo
