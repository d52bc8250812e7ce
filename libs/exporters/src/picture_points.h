// The keyframes' clouds as pictures show them: thinned, without the ceiling, entities in colour.
#pragma once

#include <vector>

#include "dynemo/exporters/export_params.h"
#include "dynemo/exporters/run_result.h"

namespace dynemo {

struct PicturePoint {
  Eigen::Vector3f p_map;
  std::uint32_t rgb = 0;
};

struct PicturePoints {
  std::vector<PicturePoint> structure, fragments;
};

PicturePoints picturePoints(const RunResult& run, const PictureParams& params);

}  // namespace dynemo
