// Parameters of scan matching.
#pragma once

#include <string>
#include <vector>

#include "dynemo/core/fields.h"
#include "dynemo/odometry/registration.h"
#include "dynemo/odometry/surface_points.h"

namespace dynemo {

/// Options of mrpt::slam::CICP under MRPT's own names, as far as its 3-D method has them, and the
/// point density it works on.
struct MrptIcpParams {
  double leaf_m = 0.4;
  int maxIterations = 40;
  double minAbsStep_trans = 1e-3;
  double minAbsStep_rot = 1e-3;
  double thresholdDist = 2.0;
  double thresholdAng = 0.0;
  double ALFA = 0.5;
  double smallestThresholdDist = 0.1;
  int corresponding_points_decimation = 1;
};
void fields(FieldVisitor& v, MrptIcpParams& p);

/// Two registrations by odometry's own core: a coarse one of a part of the points, then a fine one
/// of all.
struct AnnealedGicpParams {
  RegistrationParams coarse;
  RegistrationParams fine;
  int coarse_stride = 4;
  double max_correspondence_m = 2.0;
  double fine_correspondence_m = 0.5;

  AnnealedGicpParams();
};
void fields(FieldVisitor& v, AnnealedGicpParams& p);

struct PclGicpParams {
  double max_correspondence_m = 1.0;
  int max_iterations = 50;
  double translation_tolerance_m = 5e-4;
  double rotation_tolerance_rad = 2e-4;
};
void fields(FieldVisitor& v, PclGicpParams& p);

struct PclNdtParams {
  double resolution_m = 1.0;
  double step_m = 0.1;
  double outlier_ratio = 0.55;
  int max_iterations = 50;
  double tolerance = 1e-4;
};
void fields(FieldVisitor& v, PclNdtParams& p);

/// How every match is judged, whatever found it.
struct AssessmentParams {
  double overlap_m = 0.3;
  double inlier_m = 0.05;
  double min_overlap = 0.1;
  double min_eigenvalue = 0.003;
  double max_contradiction = 0.08;
  double min_residual_m = 0.005;
};
void fields(FieldVisitor& v, AssessmentParams& p);

struct MatchingParams {
  std::vector<std::string> chain = {"mrpt_icp", "annealed_gicp"};
  SurfaceParams scan;
  int min_points = 100;
  double refined_translation_sigma_m = 0.2;
  double refined_rotation_sigma_rad = 0.04;
  double yaw_step_rad = 0.5;
  double max_single_sigma_rad = 0.4;
  MrptIcpParams mrpt_icp;
  AnnealedGicpParams annealed_gicp;
  PclGicpParams pcl_gicp;
  PclNdtParams pcl_ndt;
  AssessmentParams assessment;

  MatchingParams();
};
void fields(FieldVisitor& v, MatchingParams& p);

}  // namespace dynemo
