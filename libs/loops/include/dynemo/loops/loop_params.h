// Parameters of loop closure, one struct per step.
#pragma once

#include <optional>
#include <string>

#include "dynemo/core/fields.h"
#include "dynemo/graph/robust_kernel.h"
#include "dynemo/matching/matching_params.h"

namespace dynemo {

enum class CandidateGate {
  kDistance,    ///< a fixed radius
  kUncertainty  ///< a radius that grows with the uncertainty of the pair's relative position
};

/// Which earlier keyframes the newest one is matched with.
struct CandidateParams {
  CandidateGate gate = CandidateGate::kDistance;
  double max_distance_m = 2.0;
  double max_height_m = 1.0;
  double min_path_m = 5.0;
  double spacing_m = 2.0;
  double spacing_s = 0.0;
  int max_candidates = 3;
  double separation_m = 2.0;
  /// kUncertainty: added to the radius, up to the limit.
  double uncertainty_sigmas = 2.0;
  double max_uncertain_distance_m = 10.0;
};
void fields(FieldVisitor& v, CandidateParams& p);

enum class AgentRemoval {
  kAlways,   ///< an agent is never a landmark
  kByMotion  ///< as objects: where its pose is inconsistent
};

/// Which entities leave the scans (paper, Sec. IV-C).
struct PrefilterParams {
  std::string method = "motion";
  double min_motion_m = 0.30;
  double min_rotation_rad = 0.35;
  double static_probability = 0.99;
  AgentRemoval agents = AgentRemoval::kAlways;
  double drift_scale = 3.0;
};
void fields(FieldVisitor& v, PrefilterParams& p);

/// Entities as evidence of a loop.
struct EntityEvidenceParams {
  bool candidates = true;
  int min_shared = 2;
  double consensus_probability = 0.99;
  double max_seed_sigma_m = 0.5;
};
void fields(FieldVisitor& v, EntityEvidenceParams& p);

/// What a closure must pass.
struct VerificationParams {
  double min_inlier_ratio = 0.5;
  double min_overlap = 0.4;
  double max_residual_m = 0.05;
  double min_eigenvalue = 0.01;
  double drift_scale = 3.0;
  double probability = 0.999;
  bool pairwise = true;
  double max_chain_sigma_m = 0.3;
  double max_graph_sigmas = 6.0;
};
void fields(FieldVisitor& v, VerificationParams& p);

/// How much a closure weighs in the graph.
struct ClosureNoiseParams {
  double covariance_scale = 3.0;
  double min_sigma_m = 0.01;
  double min_sigma_rad = 0.002;
  double clean_residual_m = 0.01;
  double residual_share = 8.0;
  double correlation_m = 3.0;
  KernelType kernel = KernelType::kCauchy;
  double kernel_width = 2.0;
};
void fields(FieldVisitor& v, ClosureNoiseParams& p);

struct LoopParams {
  bool enabled = true;
  CandidateParams candidates;
  PrefilterParams prefilter;
  EntityEvidenceParams entities;
  MatchingParams matching;
  VerificationParams verification;
  ClosureNoiseParams noise;
};
void fields(FieldVisitor& v, LoopParams& p);

}  // namespace dynemo
