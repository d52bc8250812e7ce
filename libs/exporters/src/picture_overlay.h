// What is written into a rendered picture: names of entities, a legend, a scale.
#pragma once

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "picture_camera.h"

namespace dynemo {

struct PictureLabel {
  std::string text;
  Vector3 p_map;  ///< what it points at
  std::uint32_t rgb = 0;
};

struct LegendEntry {
  std::string text;
  std::uint32_t rgb = 0;
};

/// Labels over their points, moved apart where they would cover each other.
void drawLabels(cv::Mat& picture, const PictureCamera& camera,
                const std::vector<PictureLabel>& labels);

/// A title with coloured entries below it in the upper left corner.
void drawLegend(cv::Mat& picture, const std::string& title,
                const std::vector<LegendEntry>& entries);

/// A bar of round length in the lower left corner; right at the distance of the view's middle.
void drawScale(cv::Mat& picture, const PictureCamera& camera);

}  // namespace dynemo
