// What every registered edge owes the solver: right Jacobians, and residuals that do not depend on
// the map's origin.
#include <numbers>

#include "dynemo/core/error.h"
#include "dynemo/graph/node_floor.h"
#include "dynemo/graph/node_plane.h"
#include "registered_types.h"

namespace dynemo::test {
namespace {

constexpr int kStates = 60;
constexpr double kDifference = 1e-6;
constexpr double kJacobianTolerance =
    2e-8;  // of central differences, per unit of the largest entry
constexpr double kGaugeTolerance = 1e-11;
/// The rotation vector jumps at π: states closer than this are drawn again.
constexpr double kMarginToPi_rad = 0.05;

class Edges : public ::testing::TestWithParam<EdgeType> {
 protected:
  std::mt19937_64 rng_{20240601};
};

bool nearPi(const Residual& e) {
  return e.size() == 6 && e.tail<3>().norm() > std::numbers::pi - kMarginToPi_rad;
}

JacobianBlock centralDifferences(const CEdgeBase& edge, const CNodeBase& node, std::size_t which,
                                 const std::vector<CNodeBase::Ptr>& nodes) {
  JacobianBlock J(edge.residualSize(), node.tangentSize());
  States moved(nodes), at(nodes);
  for (int i = 0; i < node.tangentSize(); ++i) {
    double delta[kMaxTangent] = {};
    delta[i] = kDifference;
    node.retract(at.of(which), delta, moved.of(which));
    const Residual plus = residualAt(edge, moved);
    delta[i] = -kDifference;
    node.retract(at.of(which), delta, moved.of(which));
    J.col(i) = (plus - residualAt(edge, moved)) / (2.0 * kDifference);
  }
  return J;
}

TEST_P(Edges, JacobiansEqualCentralDifferences) {
  double largest_rotation = 0.0;
  for (int sample = 0; sample < kStates;) {
    const CEdgeBase::Ptr edge = GetParam().example(rng_);
    const auto nodes = examplesFor(GetParam(), rng_);
    const States states(nodes);
    Residual e;
    Jacobians J;
    edge->evaluate(states.pointers(), e, &J);
    ASSERT_EQ(e.size(), edge->residualSize());
    if (nearPi(e)) continue;
    ++sample;
    if (e.size() == 6) largest_rotation = std::max(largest_rotation, e.tail<3>().norm());
    EXPECT_GT(e.norm(), 1e-3) << "a residual of zero would hide wrong terms";
    EXPECT_EQ((e - residualAt(*edge, states)).norm(), 0.0)
        << "e must not depend on whether J is asked for";
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const JacobianBlock numeric = centralDifferences(*edge, *nodes[i], i, nodes);
      ASSERT_EQ(J[i].rows(), numeric.rows());
      ASSERT_EQ(J[i].cols(), numeric.cols());
      EXPECT_LT((J[i] - numeric).cwiseAbs().maxCoeff(),
                kJacobianTolerance * std::max(1.0, numeric.cwiseAbs().maxCoeff()))
          << "by node " << i << "\nanalytic\n"
          << J[i] << "\nnumeric\n"
          << numeric;
    }
  }
  if (GetParam().example(rng_)->residualSize() == 6) {
    EXPECT_GT(largest_rotation, 2.5);
  }
}

/// Moves every node as if the map's origin moved by T (new ← old).
void moveMap(const Pose3& T, std::vector<CNodeBase::Ptr>& nodes) {
  for (auto& node : nodes) {
    if (auto* pose = dynamic_cast<CNodePose*>(node.get())) {
      pose->T_map_node = T * pose->T_map_node;
    } else if (auto* floor = dynamic_cast<CNodeFloor*>(node.get())) {
      floor->level_m += T.t.z();
    } else if (auto* plane = dynamic_cast<CNodePlane*>(node.get())) {
      plane->plane_map = T * plane->plane_map;
    }
  }
}

bool isAbsolute(const EdgeType& type) { return type.node_kinds.size() == 1; }
bool namesFloor(const EdgeType& type) {
  return std::count(type.node_kinds.begin(), type.node_kinds.end(), "floor") > 0;
}

TEST_P(Edges, RelativeOnesDoNotDependOnTheMapsOrigin) {
  for (int sample = 0; sample < kStates; ++sample) {
    const CEdgeBase::Ptr edge = GetParam().example(rng_);
    auto nodes = examplesFor(GetParam(), rng_);
    const Residual before = residualAt(*edge, States(nodes));
    // A floor is horizontal, so only yaw and translations leave it one.
    Pose3 T = randomPose(rng_);
    if (namesFloor(GetParam()))
      T = Pose3::fromYawPitchRoll(T.t.x(), T.t.y(), T.t.z(), T.t.x(), 0, 0);
    moveMap(T, nodes);
    const Residual after = residualAt(*edge, States(nodes));
    if (nearPi(before)) continue;
    if (isAbsolute(GetParam())) {
      EXPECT_GT((after - before).norm(), 1e-3) << "an edge of one node is what fixes the gauge";
    } else if (GetParam().kind == "agent_velocity" || GetParam().kind == "plane_parallel") {
      // Their axes are the map's, so they turn with it.
      EXPECT_LT((after - T.R * before).norm(), kGaugeTolerance * (1.0 + before.norm()));
    } else {
      EXPECT_LT((after - before).norm(), kGaugeTolerance * (1.0 + before.norm()));
    }
  }
}

TEST_P(Edges, WhiteningSquaresToTheInformation) {
  for (int sample = 0; sample < kStates; ++sample) {
    const CEdgeBase::Ptr edge = GetParam().example(rng_);
    const MatrixX U = edge->sqrtInformation();
    EXPECT_LT((U.transpose() * U - edge->information()).norm(), 1e-12 * edge->information().norm());
    const MatrixX covariance = MatrixX(edge->information()).inverse();
    edge->setCovariance(covariance);
    EXPECT_LT((edge->information() * covariance - MatrixX::Identity(U.rows(), U.rows())).norm(),
              1e-9);
  }
}

TEST_P(Edges, RefuseAnInformationThatIsNotPositiveDefinite) {
  const CEdgeBase::Ptr edge = GetParam().example(rng_);
  const int n = edge->residualSize();
  const MatrixX before = edge->information();
  MatrixX nan = MatrixX::Identity(n, n);
  nan(0, 0) = std::nan("");
  MatrixX negative = MatrixX::Identity(n, n);
  negative(n - 1, n - 1) = -1.0;
  for (const MatrixX& bad :
       {MatrixX(MatrixX::Zero(n, n)), nan, negative, MatrixX(MatrixX::Identity(n + 1, n + 1))}) {
    EXPECT_THROW(edge->setInformation(bad), DataError);
    EXPECT_THROW(edge->setCovariance(bad), DataError);
  }
  EXPECT_EQ(edge->information(), before);
}

INSTANTIATE_TEST_SUITE_P(Registry, Edges, ::testing::ValuesIn(edgeTypes()), KindName());

}  // namespace
}  // namespace dynemo::test
