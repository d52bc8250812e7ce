#include "dynemo/loops/loop_params.h"

namespace dynemo {

void fields(FieldVisitor& v, CandidateParams& p) {
  v.choice("gate", p.gate, {"distance", "uncertainty"},
           "A fixed radius, or one that grows with the uncertainty of the relative position");
  v.number("max_distance_m", p.max_distance_m, "Largest distance of the pair, seen from above",
           Range::positive());
  v.number("max_height_m", p.max_height_m, "Largest difference in height: storeys look alike",
           Range::positive());
  v.number("min_path_m", p.min_path_m, "Least path driven between the two", Range::positive());
  v.number("spacing_m", p.spacing_m, "Least path driven since the last closure",
           Range::nonNegative());
  v.number("spacing_s", p.spacing_s, "Least time since the last closure", Range::nonNegative());
  v.integer("max_candidates", p.max_candidates,
            "Scan matches per keyframe; the best one that passes becomes a closure",
            Range::between(1, 1000));
  v.number("separation_m", p.separation_m,
           "Least path between two candidates of one keyframe: different passes say more",
           Range::nonNegative());
  v.number("uncertainty_sigmas", p.uncertainty_sigmas,
           "Gate by uncertainty: the radius grows by so many standard deviations",
           Range::positive());
  v.number("max_uncertain_distance_m", p.max_uncertain_distance_m,
           "Gate by uncertainty: largest radius", Range::positive());
}

void fields(FieldVisitor& v, PrefilterParams& p) {
  v.text("method", p.method,
         "Entities whose points leave the scans: none, always (all), motion (those that moved)");
  v.number("min_motion_m", p.min_motion_m,
           "delta'_E: displacement between the two keyframes that is motion", Range::positive());
  v.angle("min_rotation_deg", p.min_rotation_rad,
          "delta'_E: rotation between the two keyframes that is motion", Range::positive());
  v.number("static_probability", p.static_probability,
           "And beyond this chi-square(6) quantile of the combined covariance",
           Range::between(0.5, 0.999999));
  v.choice("agents", p.agents, {"always", "by_motion"},
           "motion: whether agents leave the scans always, or by the same rule as objects");
  v.number("drift_scale", p.drift_scale,
           "A displacement shared by most objects is drift where it is within so many times the "
           "graph's standard deviations",
           Range::positive());
}

void fields(FieldVisitor& v, EntityEvidenceParams& p) {
  v.flag("candidates", p.candidates,
         "Match keyframes that see the same unmoved objects, however far apart the estimate puts "
         "them");
  v.integer("min_shared", p.min_shared, "Objects that must agree on the relative pose",
            Range::between(1, 100));
  v.number("consensus_probability", p.consensus_probability,
           "chi-square(6) quantile within which two objects agree", Range::between(0.5, 0.999999));
  v.number("max_seed_sigma_m", p.max_seed_sigma_m,
           "Objects that locate the robot worse than this start no match", Range::positive());
}

void fields(FieldVisitor& v, VerificationParams& p) {
  v.number("min_inlier_ratio", p.min_inlier_ratio,
           "Least share of close correspondences after the match", Range::between(0.0, 1.0));
  v.number("min_overlap", p.min_overlap, "Least share of the scan that the other one covers",
           Range::between(0.0, 1.0));
  v.number("max_residual_m", p.max_residual_m, "Largest rms distance of the correspondences",
           Range::positive());
  v.number("min_eigenvalue", p.min_eigenvalue,
           "Least share of the points that constrain the weakest direction",
           Range::between(0.0, 1.0));
  v.number("drift_scale", p.drift_scale,
           "Factor on the graph's standard deviations when a closure is held against it",
           Range::positive());
  v.number("probability", p.probability,
           "chi-square(6) quantile of every comparison with the graph, odometry, or closures",
           Range::between(0.5, 0.999999));
  v.flag("pairwise", p.pairwise, "Hold closures against each other along the odometry");
  v.number("max_chain_sigma_m", p.max_chain_sigma_m,
           "Odometry between two closures that is less certain than this says nothing",
           Range::positive());
  v.number("max_graph_sigmas", p.max_graph_sigmas,
           "A closure that the optimised graph contradicts by more is taken out again",
           Range::positive());
}

void fields(FieldVisitor& v, ClosureNoiseParams& p) {
  v.number("covariance_scale", p.covariance_scale,
           "Factor on the matcher's standard deviations: neighbouring points err together",
           Range::positive());
  v.number("min_sigma_m", p.min_sigma_m, "Least sigma of a closure", Range::positive());
  v.angle("min_sigma_deg", p.min_sigma_rad, "Least sigma of a closure", Range::positive());
  v.number("clean_residual_m", p.clean_residual_m,
           "Residual of undistorted scans: what exceeds it pulls all points the same way",
           Range::nonNegative());
  v.number(
      "residual_share", p.residual_share,
      "Times that excess is added to the least sigma, at the scan's mean range for the rotation",
      Range::nonNegative());
  v.number("correlation_m", p.correlation_m,
           "Closures whose ends are nearer than this along the path share their errors: each "
           "further one weighs less",
           Range::nonNegative());
  v.choice("kernel", p.kernel, {"none", "huber", "cauchy", "tukey", "geman_mcclure"},
           "Robust kernel of closures in the graph");
  v.number("kernel_width", p.kernel_width, "Its width in standard deviations", Range::positive());
}

void fields(FieldVisitor& v, LoopParams& p) {
  v.flag("enabled", p.enabled, "Close loops between keyframes");
  v.section("candidates", p.candidates, "Pairs of keyframes that are matched");
  v.section("prefilter", p.prefilter, "Entity points that leave the scans before the match");
  v.section("entities", p.entities, "Entities as evidence of a loop");
  v.section("matching", p.matching, "Scan matching");
  v.section("verification", p.verification, "What a closure must pass");
  v.section("noise", p.noise, "How much a closure weighs");
}

}  // namespace dynemo
