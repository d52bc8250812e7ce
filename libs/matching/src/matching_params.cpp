#include "dynemo/matching/matching_params.h"

namespace dynemo {

AnnealedGicpParams::AnnealedGicpParams() {
  coarse.min_correspondence_m = 0.5;
  coarse.kernel_m = 0.15;
  coarse.annealing = 0.8;
  coarse.translation_tolerance_m = 5e-3;
  coarse.rotation_tolerance_rad = 1e-3;
  coarse.min_observed_share = fine.min_observed_share = 0.003;
  fine.min_correspondence_m = 0.3;
  fine.kernel_m = 0.045;
  fine.translation_tolerance_m = 2e-4;
  fine.rotation_tolerance_rad = 5e-5;
}

MatchingParams::MatchingParams() {
  scan.leaf_m = 0.2;
  // Fits across a corner lean towards the sensor in both scans, as if the place had such surfaces.
  scan.max_flatness = 0.03;
}

void fields(FieldVisitor& v, MrptIcpParams& p) {
  v.number("leaf_m", p.leaf_m, "Edge of the cubes in which one point is kept", {0.01, 10.0});
  v.integer("maxIterations", p.maxIterations, "Iterations", Range::between(1, 1000));
  v.number("minAbsStep_trans", p.minAbsStep_trans,
           "Translation below which the threshold shrinks, or the iteration ends [m]",
           Range::positive());
  v.number("minAbsStep_rot", p.minAbsStep_rot,
           "Rotation below which the threshold shrinks, or the iteration ends [rad]",
           Range::positive());
  v.number("thresholdDist", p.thresholdDist, "First distance of correspondences [m]",
           Range::positive());
  v.number("thresholdAng", p.thresholdAng,
           "Growth of that distance with the distance of a point from the sensor [rad]",
           Range::nonNegative());
  v.number("ALFA", p.ALFA, "Factor by which the threshold shrinks", {0.0, 0.99, true});
  v.number("smallestThresholdDist", p.smallestThresholdDist,
           "Smallest distance of correspondences [m]", Range::positive());
  v.integer("corresponding_points_decimation", p.corresponding_points_decimation,
            "Every so manieth point takes part", Range::between(1, 1000));
}

void fields(FieldVisitor& v, AnnealedGicpParams& p) {
  v.section("coarse", p.coarse, "While correspondences may be far apart");
  v.section("fine", p.fine, "From fine_correspondence_m to the end");
  v.integer("coarse_stride", p.coarse_stride,
            "The coarse registration takes every so manieth point", Range::between(1, 100));
  v.number("max_correspondence_m", p.max_correspondence_m,
           "Upper limit of the first correspondence distance, which is three times the guess's "
           "uncertainty",
           Range::positive());
  v.number("fine_correspondence_m", p.fine_correspondence_m,
           "First correspondence distance of the fine registration; a better guess needs no coarse "
           "one",
           Range::positive());
}

void fields(FieldVisitor& v, PclGicpParams& p) {
  v.number("max_correspondence_m", p.max_correspondence_m, "Largest distance of correspondences",
           Range::positive());
  v.integer("max_iterations", p.max_iterations, "Iterations", Range::between(1, 1000));
  v.number("translation_tolerance_m", p.translation_tolerance_m, "Step that ends the iteration",
           Range::positive());
  v.number("rotation_tolerance_rad", p.rotation_tolerance_rad, "Step that ends the iteration",
           Range::positive());
}

void fields(FieldVisitor& v, PclNdtParams& p) {
  v.number("resolution_m", p.resolution_m, "Edge of the cells", Range::positive());
  v.number("step_m", p.step_m, "Longest step of the line search", Range::positive());
  v.number("outlier_ratio", p.outlier_ratio, "Expected share of outliers", {0.0, 0.99, true});
  v.integer("max_iterations", p.max_iterations, "Iterations", Range::between(1, 1000));
  v.number("tolerance", p.tolerance, "Step that ends the iteration [m, rad]", Range::positive());
}

void fields(FieldVisitor& v, AssessmentParams& p) {
  v.number("overlap_m", p.overlap_m,
           "Points with a point of the other scan as near as this are in the overlap",
           Range::positive());
  v.number("inlier_m", p.inlier_m, "Of these, points as close as this along the normal are inliers",
           Range::positive());
  v.number("min_overlap", p.min_overlap, "Scans with a smaller overlap have no match",
           Range::between(0.0, 1.0));
  v.number("min_eigenvalue", p.min_eigenvalue,
           "Scans with a smaller eigenvalue of the mean Hessian are degenerate",
           Range::between(0.0, 1.0));
  v.number("max_contradiction", p.max_contradiction,
           "A match that puts a larger share of one scan's points where the other's sensor looked "
           "through is wrong",
           Range::between(0.0, 1.0));
  v.number("min_residual_m", p.min_residual_m,
           "Lower limit of the residual's standard deviation in the covariance", Range::positive());
}

void fields(FieldVisitor& v, MatchingParams& p) {
  v.texts("chain", p.chain,
          "Matchers from coarse to fine, each refining the one before: mrpt_icp, annealed_gicp, "
          "pcl_gicp, pcl_ndt");
  v.section("scan", p.scan, "Reduction of scans to points with normals");
  v.integer("min_points", p.min_points, "Scans with fewer points after reduction are refused",
            Range::between(10, 1e6));
  v.number("refined_translation_sigma_m", p.refined_translation_sigma_m,
           "How far off a result may be that the next matcher refines", Range::positive());
  v.number("refined_rotation_sigma_rad", p.refined_rotation_sigma_rad,
           "How far off a result may be that the next matcher refines", Range::positive());
  v.number("max_single_sigma_rad", p.max_single_sigma_rad,
           "With a less certain rotation the first matcher starts at several yaw angles",
           Range::positive());
  v.number("yaw_step_rad", p.yaw_step_rad, "Step between these angles", {0.01, 3.15});
  v.section("mrpt_icp", p.mrpt_icp, "mrpt::slam::CICP::Align3D, by MRPT's names");
  v.section("annealed_gicp", p.annealed_gicp, "Annealed robust generalised ICP");
  v.section("pcl_gicp", p.pcl_gicp, "pcl::GeneralizedIterativeClosestPoint");
  v.section("pcl_ndt", p.pcl_ndt, "pcl::NormalDistributionsTransform");
  v.section("assessment", p.assessment, "How matches are judged");
}

}  // namespace dynemo
