#include "ceres_reference.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <ctime>
#include <stdexcept>

#include "dynemo/graph/edge_agent_motion.h"
#include "dynemo/graph/edge_floor_entity.h"
#include "dynemo/graph/edge_plane.h"
#include "dynemo/graph/edge_prior.h"
#include "dynemo/graph/edge_relative_pose.h"

// Present when the system's BLAS is OpenBLAS.
extern "C" [[gnu::weak]] void openblas_set_num_threads(int threads);

namespace dynemo::test {
namespace {

template <class T>
using V3 = Eigen::Matrix<T, 3, 1>;
template <class T>
using Q = Eigen::Quaternion<T>;

/// A pose parameter block is [x y z qx qy qz qw].
template <class T>
V3<T> position(const T* p) {
  return Eigen::Map<const V3<T>>(p);
}
template <class T>
Q<T> rotation(const T* p) {
  return Q<T>(Eigen::Map<const Q<T>>(p + 3));
}

template <class T>
V3<T> rotationVector(const Q<T>& q) {
  const T wxyz[4] = {q.w(), q.x(), q.y(), q.z()};
  V3<T> w;
  ceres::QuaternionToAngleAxis(wxyz, w.data());
  return w;
}

template <class T>
void poseError(const V3<T>& t, const Q<T>& q, const Pose3& measured, T* e) {
  const Q<T> q_measured = Eigen::Quaterniond(measured.R).cast<T>();
  Eigen::Map<V3<T>>{e} = q_measured.conjugate() * (t - measured.t.cast<T>());
  Eigen::Map<V3<T>>{e + 3} = rotationVector<T>(q_measured.conjugate() * q);
}

template <int N, class T>
bool whiten(const MatrixX& U, T* e) {
  Eigen::Map<Eigen::Matrix<T, N, 1>> error(e);
  error = (U.template cast<T>() * error).eval();
  return true;
}

struct RelativePose {
  static constexpr int kSize = 6;
  Pose3 measured;
  MatrixX U;
  template <class T>
  bool operator()(const T* a, const T* b, T* e) const {
    const Q<T> inverse = rotation(a).conjugate();
    poseError<T>(inverse * (position(b) - position(a)), inverse * rotation(b), measured, e);
    return whiten<6>(U, e);
  }
};

struct PosePrior {
  Pose3 measured;
  MatrixX U;
  template <class T>
  bool operator()(const T* a, T* e) const {
    poseError<T>(position(a), rotation(a), measured, e);
    return whiten<6>(U, e);
  }
};

struct FloorPrior {
  double level, u;
  template <class T>
  bool operator()(const T* floor, T* e) const {
    e[0] = u * (floor[0] - level);
    return true;
  }
};

struct FloorEntity {
  double offset, u;
  template <class T>
  bool operator()(const T* floor, const T* entity, T* e) const {
    e[0] = u * (floor[0] - entity[2] - offset);
    return true;
  }
};

/// Written with the projector I − uuᵀ: whitening with a multiple of the identity makes it equal to
/// two coordinates in the plane, whichever basis spans it.
struct AgentLine {
  Vector3 direction;
  double u;
  template <class T>
  bool operator()(const T* a, const T* b, T* e) const {
    const V3<T> v = rotation(a).conjugate() * (position(b) - position(a));
    const V3<T> d = direction.cast<T>();
    Eigen::Map<V3<T>>{e} = u * (v - d * d.dot(v));
    return true;
  }
};

struct AgentVelocity {
  double dt_12, dt_23;
  MatrixX U;
  template <class T>
  bool operator()(const T* a, const T* b, const T* c, T* e) const {
    Eigen::Map<V3<T>>{e} =
        (position(c) - position(b)) / dt_23 - (position(b) - position(a)) / dt_12;
    return whiten<3>(U, e);
  }
};

/// Angle and direction between the normals as a rotation vector, in the basis of the measured
/// normal; distance of the measured point.
template <class T>
bool planeError(const T* pose, const V3<T>& n_map, const T& d, const PlanePatch& measured,
                const MatrixX& U, T* e) {
  const V3<T> n_base = rotation(pose).conjugate() * n_map;
  const V3<T> n_measured = measured.normal.cast<T>();
  const V3<T> w = rotationVector<T>(Q<T>::FromTwoVectors(n_measured, n_base));
  const Eigen::Matrix<T, 3, 2> B = orthogonalBasis(measured.normal).cast<T>();
  // The rotation w × ñ is what moves the measured normal to the predicted one.
  Eigen::Map<Eigen::Matrix<T, 2, 1>>{e} = B.transpose() * w.cross(n_measured);
  e[2] = n_map.dot(rotation(pose) * measured.center.cast<T>() + position(pose)) + d;
  return whiten<3>(U, e);
}

/// A plane parameter block is [nx ny nz d].
struct KeyframePlane {
  PlanePatch measured;
  MatrixX U;
  template <class T>
  bool operator()(const T* pose, const T* plane, T* e) const {
    return planeError<T>(pose, Eigen::Map<const V3<T>>(plane), plane[3], measured, U, e);
  }
};

struct FloorGround {
  PlanePatch measured;
  MatrixX U;
  template <class T>
  bool operator()(const T* pose, const T* floor, T* e) const {
    return planeError<T>(pose, V3<T>(T(0), T(0), T(1)), -floor[0], measured, U, e);
  }
};

struct PlaneParallel {
  MatrixX U;
  template <class T>
  bool operator()(const T* a, const T* b, T* e) const {
    Eigen::Map<V3<T>>{e} = Eigen::Map<const V3<T>>(a).cross(Eigen::Map<const V3<T>>(b));
    return whiten<3>(U, e);
  }
};

struct PlanePerpendicular {
  double u;
  template <class T>
  bool operator()(const T* a, const T* b, T* e) const {
    e[0] = u * Eigen::Map<const V3<T>>(a).dot(Eigen::Map<const V3<T>>(b));
    return true;
  }
};

class GemanMcClureLoss : public ceres::LossFunction {
 public:
  explicit GemanMcClureLoss(double width) : c_(width * width) {}
  void Evaluate(double s, double rho[3]) const override {
    const double d = c_ + s;
    rho[0] = c_ * s / d;
    rho[1] = c_ * c_ / (d * d);
    rho[2] = -2.0 * c_ * c_ / (d * d * d);
  }

 private:
  double c_;
};

ceres::LossFunction* lossOf(const RobustKernel& kernel) {
  switch (kernel.type) {
    case KernelType::kHuber:
      return new ceres::HuberLoss(kernel.width);
    case KernelType::kCauchy:
      return new ceres::CauchyLoss(kernel.width);
    case KernelType::kTukey:
      return new ceres::TukeyLoss(kernel.width);
    case KernelType::kGemanMcClure:
      return new GemanMcClureLoss(kernel.width);
    case KernelType::kNone:
      break;
  }
  return nullptr;
}

/// U with UᵀU = Ω.
MatrixX root(const CEdgeBase& edge) { return MatrixX(edge.information()).llt().matrixU(); }

template <class Functor, int... Sizes>
ceres::CostFunction* costOf(Functor functor) {
  return new ceres::AutoDiffCostFunction<Functor, Sizes...>(new Functor(std::move(functor)));
}

ceres::CostFunction* costOf(const CEdgeBase& edge) {
  const MatrixX U = root(edge);
  if (const auto* e = dynamic_cast<const CEdgeRelativePose*>(&edge)) {
    return costOf<RelativePose, 6, 7, 7>({e->T_1_2, U});
  }
  if (const auto* e = dynamic_cast<const CEdgePosePrior*>(&edge))
    return costOf<PosePrior, 6, 7>({e->T_map_node, U});
  if (const auto* e = dynamic_cast<const CEdgeFloorPrior*>(&edge)) {
    return costOf<FloorPrior, 1, 1>({e->level_m, U(0, 0)});
  }
  if (const auto* e = dynamic_cast<const CEdgeFloorEntity*>(&edge)) {
    return costOf<FloorEntity, 1, 1, 7>({e->offset_m, U(0, 0)});
  }
  if (const auto* e = dynamic_cast<const CEdgeAgentLine*>(&edge)) {
    if (!U.isApprox(U(0, 0) * MatrixX::Identity(2, 2)))
      throw std::invalid_argument("agent line: isotropic noise only");
    return costOf<AgentLine, 3, 7, 7>({e->direction_entity, U(0, 0)});
  }
  if (const auto* e = dynamic_cast<const CEdgeAgentVelocity*>(&edge)) {
    return costOf<AgentVelocity, 3, 7, 7, 7>({e->dt_12_s, e->dt_23_s, U});
  }
  if (const auto* e = dynamic_cast<const CEdgeKeyframePlane*>(&edge))
    return costOf<KeyframePlane, 3, 7, 4>({e->patch_base, U});
  if (const auto* e = dynamic_cast<const CEdgeFloorGround*>(&edge))
    return costOf<FloorGround, 3, 7, 1>({e->patch_base, U});
  if (dynamic_cast<const CEdgePlaneParallel*>(&edge)) return costOf<PlaneParallel, 3, 4, 4>({U});
  if (dynamic_cast<const CEdgePlanePerpendicular*>(&edge))
    return costOf<PlanePerpendicular, 1, 4, 4>({U(0, 0)});
  throw std::invalid_argument(std::string("no Ceres residual for ") + edge.kind());
}

std::vector<double> parametersOf(const CNodeBase& node) {
  if (const auto* floor = dynamic_cast<const CNodeFloor*>(&node)) return {floor->level_m};
  if (const auto* plane = dynamic_cast<const CNodePlane*>(&node)) {
    const Plane3& p = plane->plane_map;
    return {p.normal.x(), p.normal.y(), p.normal.z(), p.d_m};
  }
  const Pose3& T = dynamic_cast<const CNodePose&>(node).T_map_node;
  const Eigen::Quaterniond q(T.R);
  return {T.t.x(), T.t.y(), T.t.z(), q.x(), q.y(), q.z(), q.w()};
}

double threadSeconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

}  // namespace

CeresResult solveWithCeres(const CSceneGraph& graph, double tolerance) {
  std::vector<std::vector<double>> blocks;
  for (const auto& node : graph.nodeSlots()) {
    blocks.push_back(node ? parametersOf(*node) : std::vector<double>{});
  }
  ceres::Problem problem;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (blocks[i].empty() || graph.edgesOf({i}).empty()) continue;
    problem.AddParameterBlock(blocks[i].data(), static_cast<int>(blocks[i].size()));
    if (blocks[i].size() == 7) {
      problem.SetManifold(blocks[i].data(),
                          new ceres::ProductManifold(new ceres::EuclideanManifold<3>(),
                                                     new ceres::EigenQuaternionManifold()));
    } else if (blocks[i].size() == 4) {
      problem.SetManifold(blocks[i].data(),
                          new ceres::ProductManifold(new ceres::SphereManifold<3>(),
                                                     new ceres::EuclideanManifold<1>()));
    }
  }
  for (const auto& edge : graph.edgeSlots()) {
    if (!edge) continue;
    std::vector<double*> parameters;
    for (const NodeId node : edge->nodes) parameters.push_back(blocks[node.value].data());
    problem.AddResidualBlock(costOf(*edge), lossOf(edge->kernel), parameters);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.max_num_iterations = 200;
  options.function_tolerance = tolerance;
  options.gradient_tolerance = 1e-12;
  options.parameter_tolerance = 1e-12;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  if (openblas_set_num_threads) openblas_set_num_threads(1);
  ceres::Solver::Summary summary;
  const double start = threadSeconds();
  ceres::Solve(options, &problem, &summary);
  const double seconds = threadSeconds() - start;
  return {summary.initial_cost, summary.final_cost, summary.IsSolutionUsable(), seconds,
          summary.num_successful_steps};
}

}  // namespace dynemo::test
