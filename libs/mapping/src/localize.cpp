#include "dynemo/mapping/localize.h"

#include <Eigen/Cholesky>

#include "dynemo/core/noise.h"
#include "dynemo/graph/robust_kernel.h"

namespace dynemo {
namespace {

constexpr int kIterations = 20;
constexpr double kConverged = 1e-10;

struct Candidate {
  Pose3 T_map_base;
  Matrix6 information;
};

std::vector<Candidate> candidates(const std::vector<EntityObservation>& observations,
                                  const CSceneGraph& graph, SemanticClass semantic_class) {
  std::vector<Candidate> list;
  for (const EntityObservation& observation : observations) {
    const CNodeEntity* mapped = graph.lastObservation(observation.entity);
    if (!mapped || observation.semantic_class != semantic_class) continue;
    // x = ε z⁻¹: a perturbation of z moves x by −Ad(z), in our right tangent.
    const Pose3 T_entity_base = observation.T_base_entity.inverse();
    const Matrix6 A = composeJacobianLeft(T_entity_base);
    const auto information = invertSpd(A * observation.covariance * A.transpose());
    if (information)
      list.push_back({mapped->T_map_entity() * T_entity_base, Matrix6(*information)});
  }
  return list;
}

}  // namespace

std::optional<Pose3> localizeFromEntities(const std::vector<EntityObservation>& observations,
                                          const CSceneGraph& graph) {
  std::vector<Candidate> list = candidates(observations, graph, SemanticClass::kObject);
  if (list.empty()) list = candidates(observations, graph, SemanticClass::kAgent);
  if (list.empty()) return std::nullopt;

  const RobustKernel kernel{KernelType::kCauchy, 3.0};
  const Candidate* best = &list.front();
  for (const Candidate& c : list) {
    if (c.information.trace() > best->information.trace()) best = &c;
  }
  Pose3 T = best->T_map_base;
  for (int i = 0; i < kIterations; ++i) {
    Matrix6 H = Matrix6::Zero();
    Vector6 g = Vector6::Zero();
    for (const Candidate& c : list) {
      const Vector6 e = local(c.T_map_base, T);
      Matrix6 J = Matrix6::Identity();
      J.topLeftCorner<3, 3>() = c.T_map_base.R.transpose() * T.R;
      J.bottomRightCorner<3, 3>() = rightJacobianInverseSO3(e.tail<3>());
      const double w = kernel(e.dot(c.information * e)).weight;
      H += w * J.transpose() * c.information * J;
      g += w * J.transpose() * c.information * e;
    }
    const Vector6 step = -H.ldlt().solve(g);
    if (!step.allFinite()) return std::nullopt;
    T = T.retract(step);
    if (step.norm() < kConverged) break;
  }
  return T;
}

}  // namespace dynemo
