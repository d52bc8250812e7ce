#include "normal_equations.h"

#include <gtest/gtest.h>

#include <random>

namespace dynemo {
namespace {

constexpr double kIsotropy = 0.01;

std::vector<WeightedResidual> randomResiduals(int count) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  const auto vector = [&] { return Vector3(normal(random), normal(random), normal(random)); };
  std::vector<WeightedResidual> all;
  for (int i = 0; i < count; ++i) {
    WeightedResidual r{vector(),
                       vector(),
                       vector().normalized(),
                       vector().normalized(),
                       vector().normalized(),
                       0,
                       0.7 + 0.1 * i,
                       0.3 + 0.05 * i,
                       0.02 * i - 0.05};
    r.along_normal = r.b.dot(r.e);
    all.push_back(r);
  }
  return all;
}

Eigen::Matrix<double, 3, 6> jacobian(const Vector3& s) {
  Eigen::Matrix<double, 3, 6> A;
  A << Matrix3::Identity(), -skew(s);
  return A;
}

TEST(NormalEquations, SumsEqualTheirDefinitions) {
  const auto residuals = randomResiduals(7);
  NormalEquations first(true, kIsotropy), second(true, kIsotropy);
  for (std::size_t i = 0; i < residuals.size(); ++i) (i < 3 ? first : second).add(residuals[i]);
  first.add(second);
  for (int order = 0; order <= 2 * NormalEquations::kDegree; ++order) {
    Matrix6 H = Matrix6::Zero();
    Vector6 g = Vector6::Zero();
    for (const WeightedResidual& r : residuals) {
      const auto A = jacobian(r.s);
      const Matrix3 M =
          r.weight_normal * r.b * r.b.transpose() + r.weight * kIsotropy * Matrix3::Identity();
      const double power = std::pow(r.tau_s, order);
      H += power * A.transpose() * M * A;
      g += power * A.transpose() * M * r.e;
    }
    EXPECT_LT((first.hessian(order) - H).norm(), 1e-12 * (1 + H.norm())) << "order " << order;
    if (order <= NormalEquations::kDegree) {
      EXPECT_LT((first.gradient(order) - g).norm(), 1e-12 * (1 + g.norm())) << "order " << order;
    }
  }
}

TEST(NormalEquations, AgreementIsTheSymmetricProductOfBothNormals) {
  Matrix6 expected = Matrix6::Zero();
  NormalEquations sums(false, kIsotropy);
  for (const WeightedResidual& r : randomResiduals(7)) {
    sums.add(r);
    const auto A = jacobian(r.s);
    const Matrix6 product = A.transpose() * r.n * r.n_target.transpose() * A;
    expected += 0.5 * r.weight * (product + product.transpose());
  }
  EXPECT_LT((sums.agreement() - expected).norm(), 1e-12 * expected.norm());
}

/// A dθ-first perturbation of the pose and of the motion moves a point as the sums assume.
TEST(NormalEquations, JacobianAgreesWithFiniteDifferences) {
  const Pose3 T(expSO3({0.3, -0.2, 0.5}), {1, 2, 3});
  const Vector3 p_base(2, -1, 0.5);
  const Vector3 s = T.R * p_base;
  const auto A = jacobian(s);
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 6; ++i) {
    Vector6 d = Vector6::Zero();
    d[i] = kStep;
    const Pose3 moved(expSO3(d.tail<3>()) * T.R, T.t + d.head<3>());
    EXPECT_LT(((moved * p_base - T * p_base) / kStep - A.col(i)).norm(), 1e-5) << "column " << i;
  }
}

}  // namespace
}  // namespace dynemo
