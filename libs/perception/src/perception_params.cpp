#include "dynemo/perception/perception_params.h"

namespace dynemo {

void fields(FieldVisitor& v, TagFinderParams& p) {
  v.number("decimate", p.decimate,
           "Tags are searched in the image reduced by this factor (1.5 or a whole number): faster, "
           "but small tags are lost",
           {1.0, 16.0});
  v.number("blur_sigma_px", p.blur_sigma_px, "Gaussian blur before the search, for noisy images",
           Range::between(0.0, 10.0));
  v.flag("refine_edges", p.refine_edges, "Snap the edges of each tag to the image gradient");
  v.number("decode_sharpening", p.decode_sharpening, "Sharpening of the tag's bits",
           Range::nonNegative());
  v.integer("threads", p.threads, "Threads of the search", Range::between(1, 64));
  v.integer("max_hamming", p.max_hamming,
            "Wrong bits that are corrected (fewer for tag families with very many codes)",
            Range::between(0, 2));
  v.number("min_decision_margin", p.min_decision_margin,
           "Mean contrast of the bits [grey levels] below which a tag is dropped",
           Range::nonNegative());
  v.integer("min_white_black_diff", p.min_white_black_diff,
            "Contrast [grey levels] below which a part of the image is not searched",
            Range::between(0, 255));
}

void fields(FieldVisitor& v, TagPoseParams& p) {
  v.number("corner_sigma_base_px", p.corner_sigma_base_px,
           "Corner noise: σ = max(floor, base + slope / (edge · cos tilt))", Range::nonNegative());
  v.number("corner_sigma_slope_px2", p.corner_sigma_slope_px2, "See corner_sigma_base_px",
           Range::nonNegative());
  v.number("corner_sigma_floor_px", p.corner_sigma_floor_px, "See corner_sigma_base_px",
           Range::positive());
  v.number("min_edge_px", p.min_edge_px, "Tags that are narrower in the image are not used",
           Range::nonNegative());
  v.number("max_reprojection_px", p.max_reprojection_px,
           "RMS corner error above which a tag, or a pose, is rejected", Range::positive());
  v.integer("max_iterations", p.max_iterations, "Levenberg–Marquardt steps",
            Range::between(1, 1000));
}

void fields(FieldVisitor& v, AmbiguityParams& p) {
  v.number("min_evidence", p.min_evidence,
           "Of the two poses of a planar tag the better is trusted when its squared whitened error "
           "is smaller by this much, priors included",
           Range::nonNegative());
  v.flag("entities_are_upright", p.entities_are_upright,
         "Entities stand on the ground with their z axis up");
  v.angle("upright_sigma_deg", p.upright_sigma_rad, "Tilt of an upright entity", {0.0, 90.0, true});
  v.angle("prediction_sigma_deg", p.prediction_sigma_rad,
          "Change of an entity's orientation since its last observation", {0.0, 180.0, true});
  v.number("prediction_max_age_s", p.prediction_max_age_s, "An older observation predicts nothing",
           Range::nonNegative());
  v.choice("fallback", p.fallback, {"reject", "inflate"},
           "When nothing decides: drop the detection, or widen its covariance over both poses");
}

void fields(FieldVisitor& v, ExternalDetectorParams& p) {
  v.number("default_sigma_translation_m", p.default_sigma_translation_m,
           "For detections without a covariance", Range::positive());
  v.angle("default_sigma_rotation_deg", p.default_sigma_rotation_rad,
          "For detections without a covariance", {0.0, 180.0, true});
}

void fields(FieldVisitor& v, PerceptionParams& p) {
  v.texts("detectors", p.detectors, "Entity detectors in use: apriltag, external");
  v.section("tag_finder", p.tag_finder, "AprilTag search");
  v.section("tag_pose", p.tag_pose, "Entity pose from tag corners");
  v.section("ambiguity", p.ambiguity, "The two poses of a planar tag");
  v.number("min_sigma_translation_m", p.min_sigma_translation_m,
           "Least translation standard deviation of a tag pose", Range::nonNegative());
  v.angle("min_sigma_rotation_deg", p.min_sigma_rotation_rad,
          "Least rotation standard deviation of a tag pose", Range::between(0.0, 180.0));
  v.section("external", p.external, "Detections of other programs");
  v.section("fragments", p.fragments, "Point-cloud fragments of entities");
  v.section("planes", p.planes, "Walls, ceiling and ground in the scans");
}

}  // namespace dynemo
