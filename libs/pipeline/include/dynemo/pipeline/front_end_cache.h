// What the front-end found in each frame without looking at the map: LiDAR odometry, entity
// detections, and planes. No setup changes it, so one run can record it in a file and the runs of
// other setups replay it, with the same results to the byte.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "dynemo/odometry/scan_odometry.h"
#include "dynemo/perception/entity_detector.h"
#include "dynemo/perception/plane_extractor.h"
#include "dynemo/pipeline/params.h"

namespace dynemo {

class RecordReader;
class RecordWriter;

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
  /// Keyframes differ between setups, and how their sweeps are straightened: planes lie beside the
  /// file, one by one, whichever run comes to a scan first leaves them to the others.
  std::unique_ptr<PlaneExtractor> wrap(std::unique_ptr<PlaneExtractor> extractor);
  /// Makes what was recorded available to others; not after an interruption.
  void finish();

 private:
  class Odometry;
  class Detector;
  bool opens(const std::string& identity);

  std::filesystem::path file_;
  std::string identity_;
  std::filesystem::path temporary_;
  std::ifstream in_;
  std::ofstream out_;
  /// One of the two: the file is either replayed or recorded.
  std::unique_ptr<RecordReader> reader_;
  std::unique_ptr<RecordWriter> writer_;
};

/// Everything that the front-end's results depend on: the recording, its entity file, and the
/// parameters of the stages before the map.
std::string frontEndIdentity(const DynemoParams& params, const std::filesystem::path& rawlog,
                             const std::optional<std::filesystem::path>& entities);

}  // namespace dynemo
