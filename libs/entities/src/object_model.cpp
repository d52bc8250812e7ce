#include "object_model.h"

#include "dynemo/core/noise.h"
#include "dynemo/graph/edge_relative_pose.h"

namespace dynemo {

CEdgeBase::Ptr frozenRelativePose(const MotionContext& context, const MotionParams& params,
                                  const char* model_name) {
  auto edge = std::make_shared<CEdgeIntraEntity>();
  edge->nodes = {context.previous().id, context.current.id};
  edge->motion_model = model_name;
  edge->T_1_2 = context.relativePose();
  edge->setCovariance(isotropicCovariance(params.relative_sigma_m, params.relative_sigma_rad));
  return edge;
}

namespace {

/// Where the object was put down: its first observation, or the last one that was found moved.
const CNodeEntity& putDown(const MotionContext& context) {
  for (auto it = context.history.rbegin(); it != context.history.rend(); ++it) {
    if ((*it)->moved) return **it;
  }
  return *context.history.front();
}

}  // namespace

MotionConstraint ObjectModel::constrain(const MotionContext& context) const {
  const Pose3 P = context.relativePose();
  const bool moved_since_previous = isMotion(P, context.relative_covariance, params_);
  // An object that is pushed slowly moves little from one observation to the next.
  const Pose3 P_put_down =
      putDown(context).T_map_entity().inverse() * context.current.T_map_entity();

  MotionConstraint constraint;
  constraint.moved =
      moved_since_previous ||
      (context.chained && isMotion(P_put_down, context.relative_covariance, params_));
  if (moved_since_previous) {
    if (params_.form == MotionForm::kPaper) {
      constraint.edges.push_back(frozenRelativePose(context, params_, "moved_object"));
    }
    return constraint;
  }
  auto edge = std::make_shared<CEdgeIntraEntity>();
  edge->nodes = {context.previous().id, context.current.id};
  edge->motion_model = "static_object";
  edge->setCovariance(isotropicCovariance(params_.static_sigma_m, params_.static_sigma_rad));
  // Displacement that the robot's drift explains must be pulled together; what neither drift nor
  // noise explains is perhaps a small motion, and must not be.
  const bool doubtful = exceedsNoise(P, context.relative_covariance, params_);
  edge->kernel = {doubtful ? KernelType::kCauchy : KernelType::kHuber, params_.static_kernel_width};
  constraint.edges.push_back(std::move(edge));
  return constraint;
}

}  // namespace dynemo
