#include "agent_line_model.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "dynemo/core/noise.h"
#include "dynemo/graph/edge_agent_motion.h"
#include "dynemo/graph/edge_relative_pose.h"

namespace dynemo {
namespace {

/// A heading that disagrees with the walked direction by more than this was taken while the agent
/// turned.
constexpr double kMaxHeadingError_rad = 0.35;

/// Paper, Eq. (13): the relative pose projected onto u, both in the frame of ε_{t−1}.
CEdgeBase::Ptr projectedEdge(const MotionContext& context, const Vector3& u_prev,
                             const MotionParams& params) {
  auto edge = std::make_shared<CEdgeIntraEntity>();
  edge->nodes = {context.previous().id, context.current.id};
  edge->motion_model = "agent_line";
  edge->T_1_2.t = u_prev * u_prev.dot(context.relativePose().t);
  const double along2 = params.line_sigma_along_m * params.line_sigma_along_m;
  const double across2 = params.line_sigma_across_m * params.line_sigma_across_m;
  // The residual lives in the frame of the measured pose, which f leaves parallel to ε_{t−1}.
  Matrix6 covariance = isotropicCovariance(1.0, params.line_sigma_rad);
  covariance.topLeftCorner<3, 3>() =
      across2 * Matrix3::Identity() + (along2 - across2) * u_prev * u_prev.transpose();
  edge->setCovariance(covariance);
  return edge;
}

/// The earliest observation from which the agent has kept to its line until now: every later
/// displacement that is long enough to tell lies along that observation's u.
const CNodeEntity* lineAnchor(const MotionContext& context, const Vector3& u_entity,
                              double min_length_m) {
  const auto onLine = [&](const CNodeEntity& anchor, const CNodeEntity& other) {
    const Vector3 d = other.T_map_entity().t - anchor.T_map_entity().t;
    if (d.norm() < min_length_m) return true;
    const double along = std::abs(d.dot(anchor.T_map_entity().R * u_entity));
    return std::acos(std::min(1.0, along / d.norm())) < kMaxHeadingError_rad;
  };
  for (std::size_t i = 0; i < context.history.size(); ++i) {
    const CNodeEntity& anchor = *context.history[i];
    if (!onLine(anchor, context.current)) continue;
    const bool all = std::all_of(context.history.begin() + static_cast<std::ptrdiff_t>(i) + 1,
                                 context.history.end(),
                                 [&](const CNodeEntity* other) { return onLine(anchor, *other); });
    if (all) return &anchor;
  }
  return nullptr;
}

CEdgeBase::Ptr anchoredLineEdge(const MotionContext& context, const CNodeEntity& anchor,
                                const Vector3& u_anchor, const MotionParams& params) {
  auto edge = std::make_shared<CEdgeAgentLine>();
  edge->nodes = {anchor.id, context.current.id};
  edge->direction_entity = u_anchor;
  edge->setCovariance(params.line_stray_sigma_m * params.line_stray_sigma_m *
                      Eigen::Matrix2d::Identity());
  edge->kernel = {KernelType::kCauchy, 2.0};
  return edge;
}

}  // namespace

std::optional<Vector3> fitLineDirection(const MotionContext& context, const MotionParams& params) {
  const auto wanted = static_cast<std::size_t>(params.line_min_observations) - 1;
  if (context.history.size() < wanted) return std::nullopt;
  std::vector<Vector3> positions;
  for (const CNodeEntity* node : context.history.last(wanted))
    positions.push_back(node->T_map_entity().t);
  positions.push_back(context.current.T_map_entity().t);

  Vector3 mean = Vector3::Zero();
  for (const Vector3& p : positions) mean += p / static_cast<double>(positions.size());
  Matrix3 scatter = Matrix3::Zero();
  for (const Vector3& p : positions) scatter += (p - mean) * (p - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Matrix3> es(scatter);
  const Vector3 u = es.eigenvectors().col(2);
  const double rms_m = std::sqrt((es.eigenvalues()[0] + es.eigenvalues()[1]) /
                                 static_cast<double>(positions.size()));
  double low = 0.0, high = 0.0;
  for (const Vector3& p : positions) {
    low = std::min(low, u.dot(p - mean));
    high = std::max(high, u.dot(p - mean));
  }
  if (high - low < params.line_min_length_m || rms_m > params.line_max_rms_m) return std::nullopt;
  // Along the way walked, so that equal tracks give equal signs.
  return u.dot(positions.back() - positions.front()) < 0.0 ? Vector3(-u) : u;
}

MotionConstraint AgentLineModel::constrain(const MotionContext& context) const {
  MotionConstraint constraint;
  constraint.moved = isMotion(context.relativePose(), context.relative_covariance, params_);
  const bool given = context.model && context.model->direction_entity;

  if (params_.form == MotionForm::kConsistent && given) {
    const Vector3& u = *context.model->direction_entity;
    if (const CNodeEntity* anchor = lineAnchor(context, u, params_.line_min_length_m)) {
      constraint.edges.push_back(anchoredLineEdge(context, *anchor, u, params_));
      return constraint;
    }
    return without_line_.constrain(context);
  }
  std::optional<Vector3> u_prev;
  if (given) {
    u_prev = context.model->direction_entity;
  } else if (const auto u_map = fitLineDirection(context, params_)) {
    u_prev = context.previous().T_map_entity().R.transpose() * *u_map;
  }
  if (!u_prev || params_.form == MotionForm::kConsistent) {
    // A fitted line restates the positions it was fitted to: in the consistent form the velocity
    // carries them.
    return without_line_.constrain(context);
  }
  constraint.edges.push_back(projectedEdge(context, *u_prev, params_));
  return constraint;
}

}  // namespace dynemo
