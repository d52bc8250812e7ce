// What a camera sees.
#pragma once

#include <memory>
#include <opencv2/core/mat.hpp>

#include "dynemo/simulation/scene.h"

namespace dynemo::simulation {

/// Keeps buffers between images; one per thread.
class Camera {
 public:
  explicit Camera(const Scene& scene);
  ~Camera();

  /// CV_8UC3 (blue, green, red). `index` numbers the images and seeds their noise.
  cv::Mat image(std::uint64_t index, double t_s);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace dynemo::simulation
