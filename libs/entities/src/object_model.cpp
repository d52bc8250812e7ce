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

MotionConstraint ObjectModel::constrain(const MotionContext& context) const {
  MotionConstraint constraint;
  constraint.moved = isMotion(context.relativePose(), context.relative_covariance, params_);
  if (constraint.moved) {
    if (params_.form == MotionForm::kPaper) {
      constraint.edges.push_back(frozenRelativePose(context, params_, "moved_object"));
    }
    return constraint;
  }
  auto edge = std::make_shared<CEdgeIntraEntity>();
  edge->nodes = {context.previous().id, context.current.id};
  edge->motion_model = "static_object";
  edge->setCovariance(isotropicCovariance(params_.static_sigma_m, params_.static_sigma_rad));
  edge->kernel = {KernelType::kHuber, params_.static_kernel_width};
  constraint.edges.push_back(std::move(edge));
  return constraint;
}

}  // namespace dynemo
