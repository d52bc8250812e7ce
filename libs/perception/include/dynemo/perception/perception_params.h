#pragma once

#include <string>
#include <vector>

#include "dynemo/core/fields.h"
#include "dynemo/perception/fragments.h"
#include "dynemo/perception/plane_extractor.h"
#include "dynemo/perception/pose_ambiguity.h"
#include "dynemo/perception/tag_finder_params.h"
#include "dynemo/perception/tag_pose.h"

namespace dynemo {

/// Poses measured by other programs.
struct ExternalDetectorParams {
  // For detections that come without a covariance.
  double default_sigma_translation_m = 0.05;
  double default_sigma_rotation_rad = 0.1;
};
void fields(FieldVisitor& v, ExternalDetectorParams& p);

struct PerceptionParams {
  /// Names of registered detectors.
  std::vector<std::string> detectors = {"apriltag", "external"};
  TagFinderParams tag_finder;
  TagPoseParams tag_pose;
  AmbiguityParams ambiguity;
  // Calibration, mounting and time stamps leave errors that the corners do not show.
  double min_sigma_translation_m = 0.003;
  double min_sigma_rotation_rad = 0.005;
  ExternalDetectorParams external;
  FragmentParams fragments;
  PlaneParams planes;
};
void fields(FieldVisitor& v, PerceptionParams& p);

}  // namespace dynemo
