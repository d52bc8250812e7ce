// libapriltag behind a value interface.
#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "dynemo/perception/tag_family.h"
#include "dynemo/perception/tag_finder_params.h"
#include "dynemo/perception/tag_pose.h"

struct apriltag_detector;

namespace dynemo {

struct FoundTag {
  TagCornerObservation observation;
  int hamming = 0;
  double decision_margin = 0.0;
};

/// One libapriltag detector for one tag family. Not for use by two threads at a time.
class TagFinder {
 public:
  /// Throws ConfigError for an unknown family or a decimation that libapriltag does not offer.
  TagFinder(const std::string& family, const TagFinderParams& params);

  /// Tags of a CV_8UC1 image in order of id; a tag id found more than once is listed as often.
  std::vector<FoundTag> find(const cv::Mat& grey);

 private:
  TagFinderParams params_;
  TagFamily family_;
  std::unique_ptr<apriltag_detector, void (*)(apriltag_detector*)> detector_;
};

}  // namespace dynemo
