#include "dynemo/backend/chordal_initialization.h"

#include <Eigen/CholmodSupport>
#include <Eigen/Dense>
#include <algorithm>
#include <numeric>

#include "cholmod_context.h"
#include "dynemo/graph/edge_prior.h"
#include "dynemo/graph/edge_relative_pose.h"

namespace dynemo {
namespace {

using backend::SingleThreaded;
using Sparse = Eigen::SparseMatrix<double>;
using Triplets = std::vector<Eigen::Triplet<double>>;

struct Relation {
  int from, to;  ///< pose indices
  const Pose3* T_from_to;
  double rotation_weight, translation_weight;
};

struct PoseGraph {
  std::vector<NodeId> nodes;  ///< the poses that some relation names, ascending
  std::vector<Relation> relations;
  std::vector<char> has_prior;  ///< per pose
  std::vector<int> free_index;  ///< per pose; −1 for the fixed one of each part

  int freePoses() const {
    return static_cast<int>(
        std::count_if(free_index.begin(), free_index.end(), [](int i) { return i >= 0; }));
  }
};

int rootOf(std::vector<int>& parent, int i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

/// Fixes the first pose of every connected part, or the first with a prior, and numbers the others.
void chooseFreePoses(PoseGraph& graph) {
  std::vector<int> parent(graph.nodes.size());
  std::iota(parent.begin(), parent.end(), 0);
  for (const Relation& r : graph.relations) {
    const int a = rootOf(parent, r.from), b = rootOf(parent, r.to);
    parent[std::max(a, b)] = std::min(a, b);
  }
  std::vector<int> fixed(parent.size(), -1);
  const int poses = static_cast<int>(parent.size());
  for (int i = 0; i < poses; ++i) {
    int& of_part = fixed[rootOf(parent, i)];
    if (of_part < 0 || (graph.has_prior[i] && !graph.has_prior[of_part])) of_part = i;
  }
  int next = 0;
  for (int i = 0; i < poses; ++i)
    graph.free_index.push_back(fixed[rootOf(parent, i)] == i ? -1 : next++);
}

PoseGraph poseGraphOf(const CSceneGraph& scene) {
  PoseGraph graph;
  std::vector<int> index(scene.nodeSlots().size(), -1);
  const auto relative = [](const CEdgeBase::Ptr& edge) {
    return dynamic_cast<const CEdgeRelativePose*>(edge.get());
  };
  for (const auto& edge : scene.edgeSlots()) {
    if (!relative(edge)) continue;
    for (const NodeId node : edge->nodes) index[node.value] = 0;
  }
  for (std::size_t i = 0; i < index.size(); ++i) {
    if (index[i] < 0) continue;
    index[i] = static_cast<int>(graph.nodes.size());
    graph.nodes.push_back({i});
  }
  graph.has_prior.assign(graph.nodes.size(), 0);
  for (const auto& edge : scene.edgeSlots()) {
    const auto* prior = dynamic_cast<const CEdgePosePrior*>(edge.get());
    if (prior && index[prior->nodes[0].value] >= 0)
      graph.has_prior[static_cast<std::size_t>(index[prior->nodes[0].value])] = 1;
  }
  for (const auto& slot : scene.edgeSlots()) {
    const CEdgeRelativePose* edge = relative(slot);
    if (!edge || edge->nodes[0] == edge->nodes[1]) continue;
    const MatrixX covariance = MatrixX(edge->information()).inverse();
    graph.relations.push_back({index[edge->nodes[0].value], index[edge->nodes[1].value],
                               &edge->T_1_2, 3.0 / covariance.diagonal().tail<3>().sum(),
                               3.0 / covariance.diagonal().head<3>().sum()});
  }
  chooseFreePoses(graph);
  return graph;
}

/// Normal equations of a linear least-squares problem with three right-hand sides.
class RowSystem {
 public:
  explicit RowSystem(int unknowns) : rhs_(MatrixX::Zero(unknowns, 3)) {}

  void add(int row, int column, double value) { entries_.emplace_back(row, column, value); }
  MatrixX& rhs() { return rhs_; }
  Expected<MatrixX, std::string> solve() const {
    Sparse A(rhs_.rows(), rhs_.rows());
    A.setFromTriplets(entries_.begin(), entries_.end());
    const SingleThreaded single_threaded;
    Eigen::CholmodDecomposition<Sparse> factor;
    factor.cholmod().print = 0;
    factor.compute(A);
    if (factor.info() != Eigen::Success)
      return make_unexpected(std::string("its linear system is singular"));
    MatrixX x = factor.solve(rhs_);
    if (!x.allFinite())
      return make_unexpected(std::string("its linear system has no finite solution"));
    return x;
  }

 private:
  Triplets entries_;
  MatrixX rhs_;
};

void addBlock(RowSystem& system, int row, int column, const Matrix3& block) {
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) system.add(3 * row + r, 3 * column + c, block(r, c));
}

/// min Σ κ ‖R_to − R_from R_from_to‖²: with Xᵢ = Rᵢᵀ stacked, the rows of every Rᵢ are one
/// right-hand side each.
Expected<std::vector<Matrix3>, std::string> solveRotations(const PoseGraph& graph,
                                                           std::vector<Matrix3> R) {
  RowSystem system(3 * graph.freePoses());
  for (const Relation& r : graph.relations) {
    const int i = graph.free_index[r.from], j = graph.free_index[r.to];
    const Matrix3 weighted = r.rotation_weight * r.T_from_to->R;
    const Matrix3 unit = r.rotation_weight * Matrix3::Identity();
    if (i >= 0) addBlock(system, i, i, unit);
    if (j >= 0) addBlock(system, j, j, unit);
    if (i >= 0 && j >= 0) {
      addBlock(system, i, j, -weighted);
      addBlock(system, j, i, -weighted.transpose());
    }
    if (i >= 0 && j < 0) system.rhs().middleRows<3>(3 * i) += weighted * R[r.to].transpose();
    if (j >= 0 && i < 0)
      system.rhs().middleRows<3>(3 * j) += weighted.transpose() * R[r.from].transpose();
  }
  const auto X = system.solve();
  if (!X) return make_unexpected("chordal initialisation of the rotations: " + X.error());
  for (std::size_t p = 0; p < R.size(); ++p) {
    const int i = graph.free_index[p];
    if (i >= 0) R[p] = nearestRotation(X->middleRows<3>(3 * i).transpose());
  }
  return R;
}

/// min Σ τ ‖t_to − t_from − R_from t_from_to‖².
Expected<std::vector<Vector3>, std::string> solveTranslations(const PoseGraph& graph,
                                                              const std::vector<Matrix3>& R,
                                                              std::vector<Vector3> t) {
  RowSystem system(graph.freePoses());
  for (const Relation& r : graph.relations) {
    const int i = graph.free_index[r.from], j = graph.free_index[r.to];
    const double w = r.translation_weight;
    const Vector3 step = R[r.from] * r.T_from_to->t;
    if (i >= 0) {
      system.add(i, i, w);
      system.rhs().row(i) += w * ((j < 0 ? t[r.to] : Vector3::Zero().eval()) - step).transpose();
    }
    if (j >= 0) {
      system.add(j, j, w);
      system.rhs().row(j) += w * ((i < 0 ? t[r.from] : Vector3::Zero().eval()) + step).transpose();
    }
    if (i >= 0 && j >= 0) {
      system.add(i, j, -w);
      system.add(j, i, -w);
    }
  }
  const auto x = system.solve();
  if (!x) return make_unexpected("chordal initialisation of the translations: " + x.error());
  for (std::size_t p = 0; p < t.size(); ++p) {
    if (graph.free_index[p] >= 0) t[p] = x->row(graph.free_index[p]).transpose();
  }
  return t;
}

}  // namespace

Expected<void, std::string> initializeChordal(CSceneGraph& scene) {
  const PoseGraph graph = poseGraphOf(scene);
  if (graph.freePoses() == 0) return {};
  std::vector<Matrix3> R;
  std::vector<Vector3> t;
  for (const NodeId node : graph.nodes) {
    const Pose3& T = scene.getNode<CNodePose>(node).T_map_node;
    R.push_back(T.R);
    t.push_back(T.t);
  }
  const auto rotations = solveRotations(graph, std::move(R));
  if (!rotations) return make_unexpected(rotations.error());
  const auto translations = solveTranslations(graph, *rotations, std::move(t));
  if (!translations) return make_unexpected(translations.error());
  for (std::size_t p = 0; p < graph.nodes.size(); ++p) {
    double state[CNodePose::kStateSize];
    CNodePose::poseToState({(*rotations)[p], (*translations)[p]}, state);
    scene.setState(graph.nodes[p], state);
  }
  return {};
}

}  // namespace dynemo
