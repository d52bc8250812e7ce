// Images without lens distortion.
#pragma once

#include <opencv2/core/mat.hpp>

#include "dynemo/ingest/sensor_frame.h"

namespace dynemo {

/// Takes the distortion of one camera out of its images. Focal lengths, principal point and size
/// stay; pixels that the camera did not see are black.
class Rectification {
 public:
  explicit Rectification(const CameraModel& camera);
  cv::Mat operator()(const cv::Mat& image) const;

 private:
  cv::Mat x_, y_;
};

}  // namespace dynemo
