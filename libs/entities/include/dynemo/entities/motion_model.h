// Motion models by semantic class: what two consecutive observations of an entity say about each
// other (paper, Sec. IV-A, intra-entity constraint).
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "dynemo/core/fields.h"
#include "dynemo/core/registry.h"
#include "dynemo/graph/edge.h"
#include "dynemo/graph/node_entity.h"
#include "dynemo/perception/entity_model.h"

namespace dynemo {

/// Paper: f as printed, also where f is the relative pose of the very detections it connects.
/// Consistent: only constraints that add information of their own.
enum class MotionForm { kPaper, kConsistent };

struct MotionParams {
  MotionForm form = MotionForm::kConsistent;
  /// ν as a χ²₆ probability: the squared Mahalanobis norm of the relative pose up to this quantile
  /// is no motion.
  double static_probability = 0.99;
  /// Smallest displacement that counts as motion, whatever its significance: seen from afar and
  /// aslant, a tag's rotation errs by ten degrees and more, as long as the view stays the same.
  double min_motion_m = 0.10;
  double min_rotation_rad = 0.26;

  double static_sigma_m = 0.005;
  double static_sigma_rad = 0.00873;
  /// Width of the static edge's kernel in standard deviations: Huber while noise and drift explain
  /// the displacement, Cauchy when they do not.
  double static_kernel_width = 1.345;

  /// Relative pose frozen at creation (paper form, moved object or agent without a line).
  double relative_sigma_m = 0.5;
  double relative_sigma_rad = 0.5;

  /// Straight line: along u, across u, rotation.
  double line_sigma_along_m = 0.2;
  double line_sigma_across_m = 0.5;
  double line_sigma_rad = 1.0;
  /// Consistent form: how far an agent strays from its line.
  double line_stray_sigma_m = 0.05;
  /// Consistent form: change of velocity between observations, per square root of a second.
  double velocity_sigma_mps = 0.5;

  /// Fitted line: at least so many positions, spread by at least so much, off by at most so much
  /// (rms).
  int line_min_observations = 3;
  double line_min_length_m = 0.3;
  double line_max_rms_m = 0.15;
};
void fields(FieldVisitor& v, MotionParams& p);

/// What a model may look at. `current` is not in the graph yet but has its id and initial estimate.
struct MotionContext {
  const EntityModel* model =
      nullptr;  ///< nullptr for an entity without an entry in the entity file
  /// Earlier observations, oldest first; never empty.
  std::span<const CNodeEntity* const> history;
  const CNodeEntity& current;
  /// Covariance of the right tangent of P = ε_{t−1}⁻¹ ε_t: both detections and the robot's own
  /// uncertainty between them.
  Matrix6 relative_covariance;
  /// Whether intra-entity edges hold the track together: only then do its older observations lie
  /// where the previous one says.
  bool chained = true;

  const CNodeEntity& previous() const { return *history.back(); }
  /// P (paper: P_{E_i,t}, in the direction the cost compares with).
  Pose3 relativePose() const {
    return previous().T_map_entity().inverse() * current.T_map_entity();
  }
};

/// The edges that tie an observation to earlier ones, without ids; `moved` when the entity was
/// displaced since the previous one.
struct MotionConstraint {
  bool moved = false;
  std::vector<CEdgeBase::Ptr> edges;
};

class MotionModel {
 public:
  virtual ~MotionModel() = default;
  virtual MotionConstraint constrain(const MotionContext& context) const = 0;
};

/// By name: "object", "agent", "agent_line" (a straight line, given in the entity file or fitted).
using MotionModelRegistry = Registry<MotionModel, const MotionParams&>;
const MotionModelRegistry& motionModels();

/// The name of the model for an entity: its own, or the default of its class.
std::string motionModelName(SemanticClass semantic_class, const EntityModel* model);

/// Whether P is beyond ν on its covariance (paper, Eq. (11)).
bool exceedsNoise(const Pose3& P, const Matrix6& covariance, const MotionParams& params);

/// Whether P is motion worth reporting: beyond the noise and beyond the smallest motion.
bool isMotion(const Pose3& P, const Matrix6& covariance, const MotionParams& params);

}  // namespace dynemo
