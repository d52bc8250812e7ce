#include "dynemo/perception/plane_extractor.h"

namespace dynemo {

void fields(FieldVisitor& v, PlaneParams& p) {
  v.text("extractor", p.extractor, "Registered plane extractor: range_image or ransac");
  v.optionalNumber("range_sigma_m", p.range_sigma_m,
                   "Noise of the ranges; null: estimated from each scan", Range::positive());
  v.integer("min_points", p.min_points, "Least points of a plane", Range::between(10, 1e9));
  v.number("min_length_m", p.min_length_m, "Least length of a plane", Range::positive());
  v.number("min_width_m", p.min_width_m, "Least width of a plane", Range::positive());
  v.number("max_gap_m", p.max_gap_m, "Parts of a plane further apart are planes of their own",
           Range::positive());
  v.number("min_sigma_offset_m", p.min_sigma_offset_m,
           "Error of a plane's offset that the noise of its points does not show",
           Range::positive());
  v.angle("min_sigma_normal_deg", p.min_sigma_normal_rad,
          "Error of a plane's normal that the noise of its points does not show",
          Range::positive());
}

}  // namespace dynemo
