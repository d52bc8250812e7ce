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

/// Entities' points where they were seen. What only passed by is left out.
struct PicturePoints {
  std::vector<PicturePoint> structure, fragments;
};

PicturePoints picturePoints(const RunResult& run, const ExportParams& params);

}  // namespace dynemo
