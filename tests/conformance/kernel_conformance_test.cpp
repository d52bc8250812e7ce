// Every robust kernel is a kernel: quadratic at the origin, monotone, and its weight is its
// derivative.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>
#include <string>

#include "dynemo/graph/robust_kernel.h"

namespace dynemo::test {
namespace {

constexpr KernelType kAll[] = {KernelType::kNone, KernelType::kHuber, KernelType::kCauchy,
                               KernelType::kTukey, KernelType::kGemanMcClure};

class Kernels : public ::testing::TestWithParam<KernelType> {};

TEST_P(Kernels, WeightIsTheDerivative) {
  for (const double width : {0.3, 1.0, 4.0}) {
    const RobustKernel kernel{GetParam(), width};
    for (double s = 1e-3; s < 400.0; s *= 1.37) {
      const double h = 1e-6 * s;
      if (std::abs(s - width * width) < 2.0 * h) continue;  // where the pieces meet
      const double numeric = (kernel(s + h).rho - kernel(s - h).rho) / (2.0 * h);
      EXPECT_NEAR(kernel(s).weight, numeric, 1e-7) << "width " << width << ", s " << s;
    }
  }
}

TEST_P(Kernels, IsTheSquareForInliers) {
  const RobustKernel kernel{GetParam(), 2.0};
  EXPECT_EQ(kernel(0.0).rho, 0.0);
  EXPECT_EQ(kernel(0.0).weight, 1.0);
  EXPECT_NEAR(kernel(1e-6).rho, 1e-6, 1e-12);
}

TEST_P(Kernels, NeverRewardsAWorseResidual) {
  const RobustKernel kernel{GetParam(), 1.3};
  double last_rho = 0.0, last_weight = 1.0;
  for (double s = 0.0; s < 1e6; s = 1.1 * s + 0.01) {
    const auto value = kernel(s);
    EXPECT_GE(value.rho, last_rho);
    EXPECT_LE(value.weight, last_weight);
    EXPECT_GE(value.weight, 0.0);
    EXPECT_LE(value.rho, s);
    last_rho = value.rho;
    last_weight = value.weight;
  }
}

TEST_P(Kernels, BendsAtItsWidth) {
  const RobustKernel narrow{GetParam(), 1.0}, wide{GetParam(), 10.0};
  if (GetParam() == KernelType::kNone) {
    EXPECT_EQ(narrow(50.0).rho, 50.0);
  } else {
    EXPECT_LT(narrow(50.0).rho, 0.5 * wide(50.0).rho);
  }
}

TEST(Kernels, HaveDistinctNames) {
  std::set<std::string> names;
  for (const KernelType type : kAll) names.insert(kernelName(type));
  EXPECT_EQ(names.size(), std::size(kAll));
}

INSTANTIATE_TEST_SUITE_P(All, Kernels, ::testing::ValuesIn(kAll),
                         [](const auto& kernel) { return std::string(kernelName(kernel.param)); });

}  // namespace
}  // namespace dynemo::test
