#include "agent_model.h"

#include <cmath>

#include "dynemo/core/noise.h"
#include "dynemo/graph/edge_agent_motion.h"
#include "object_model.h"

namespace dynemo {
namespace {

/// Observations further apart than this say nothing about each other's velocity.
constexpr double kMaxVelocityGap_s = 2.0;
/// Detections of one frame interval: a shorter one makes the velocity all noise.
constexpr double kMinVelocityGap_s = 0.05;

CEdgeBase::Ptr velocityEdge(const MotionContext& context, const MotionParams& params) {
  if (context.history.size() < 2) return nullptr;
  const CNodeEntity& first = *context.history[context.history.size() - 2];
  const CNodeEntity& second = context.previous();
  const double dt_12_s = secondsBetween(first.stamp, second.stamp);
  const double dt_23_s = secondsBetween(second.stamp, context.current.stamp);
  if (std::min(dt_12_s, dt_23_s) < kMinVelocityGap_s ||
      std::max(dt_12_s, dt_23_s) > kMaxVelocityGap_s)
    return nullptr;
  auto edge = std::make_shared<CEdgeAgentVelocity>();
  edge->nodes = {first.id, second.id, context.current.id};
  edge->dt_12_s = dt_12_s;
  edge->dt_23_s = dt_23_s;
  const double sigma2 =
      params.velocity_sigma_mps * params.velocity_sigma_mps * 0.5 * (dt_12_s + dt_23_s);
  edge->setCovariance(sigma2 * Matrix3::Identity());
  edge->kernel = {KernelType::kCauchy, 2.0};
  return edge;
}

}  // namespace

MotionConstraint AgentModel::constrain(const MotionContext& context) const {
  MotionConstraint constraint;
  constraint.moved = isMotion(context.relativePose(), context.relative_covariance, params_);
  if (params_.form == MotionForm::kPaper) {
    constraint.edges.push_back(frozenRelativePose(context, params_, "agent"));
  } else if (auto edge = velocityEdge(context, params_)) {
    constraint.edges.push_back(std::move(edge));
  }
  return constraint;
}

}  // namespace dynemo
