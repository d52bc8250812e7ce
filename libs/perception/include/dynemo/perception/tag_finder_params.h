#pragma once

#include "dynemo/core/fields.h"

namespace dynemo {

/// How tags are searched in an image (libapriltag).
struct TagFinderParams {
  double decimate = 1.5;
  double blur_sigma_px = 0.0;
  bool refine_edges = true;
  double decode_sharpening = 0.25;
  int threads = 1;
  int max_hamming = 2;
  double min_decision_margin = 30.0;
  int min_white_black_diff = 20;
};
void fields(FieldVisitor& v, TagFinderParams& p);

}  // namespace dynemo
