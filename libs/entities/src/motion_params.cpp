#include "dynemo/core/noise.h"
#include "dynemo/entities/motion_model.h"

namespace dynemo {

void fields(FieldVisitor& v, MotionParams& p) {
  v.choice("form", p.form, {"paper", "consistent"},
           "Constraints as printed in the paper, or only those that add information of their own");
  v.number("static_probability", p.static_probability,
           "nu as a chi-square(6) probability: a relative pose up to this quantile is no motion",
           Range::between(0.5, 0.999999));
  v.number("min_motion_m", p.min_motion_m, "Smallest displacement that counts as motion",
           Range::nonNegative());
  v.angle("min_rotation_deg", p.min_rotation_rad, "Smallest rotation that counts as motion",
          Range::nonNegative());
  v.number("static_sigma_m", p.static_sigma_m, "Static object: sigma of its displacement",
           Range::positive());
  v.angle("static_sigma_deg", p.static_sigma_rad, "Static object: sigma of its rotation",
          Range::positive());
  v.number("static_kernel_width", p.static_kernel_width,
           "Static object: width of the kernel in standard deviations", Range::positive());
  v.number("relative_sigma_m", p.relative_sigma_m, "Relative pose frozen at creation: sigma",
           Range::positive());
  v.angle("relative_sigma_deg", p.relative_sigma_rad,
          "Relative pose frozen at creation: sigma of the rotation", Range::positive());
  v.number("line_sigma_along_m", p.line_sigma_along_m, "Paper's straight line: sigma along it",
           Range::positive());
  v.number("line_sigma_across_m", p.line_sigma_across_m, "Paper's straight line: sigma across it",
           Range::positive());
  v.angle("line_sigma_deg", p.line_sigma_rad, "Paper's straight line: sigma of the rotation",
          Range::positive());
  v.number("line_stray_sigma_m", p.line_stray_sigma_m,
           "Consistent straight line: how far the agent strays from it", Range::positive());
  v.number("velocity_sigma_mps", p.velocity_sigma_mps,
           "Consistent agent without a line: change of velocity per square root of a second",
           Range::positive());
  v.integer("line_min_observations", p.line_min_observations, "Fitted line: positions it takes",
            Range::between(2, 1000));
  v.number("line_min_length_m", p.line_min_length_m, "Fitted line: spread of the positions",
           Range::positive());
  v.number("line_max_rms_m", p.line_max_rms_m, "Fitted line: largest rms distance of the positions",
           Range::positive());
}

std::string motionModelName(SemanticClass semantic_class, const EntityModel* model) {
  if (model && !model->motion_model.empty()) return model->motion_model;
  return semantic_class == SemanticClass::kAgent ? "agent_line" : "object";
}

bool exceedsNoise(const Pose3& P, const Matrix6& covariance, const MotionParams& params) {
  return squaredMahalanobis(local(Pose3(), P), covariance) >
         chiSquaredQuantile(6, params.static_probability);
}

bool isMotion(const Pose3& P, const Matrix6& covariance, const MotionParams& params) {
  if (P.t.norm() < params.min_motion_m && rotationAngle(P) < params.min_rotation_rad) return false;
  return exceedsNoise(P, covariance, params);
}

}  // namespace dynemo
