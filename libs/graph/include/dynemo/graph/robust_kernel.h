// Robust kernels ρ(s) of the squared whitened residual s = ‖U e‖², with ρ(s) ≈ s for inliers.
#pragma once

#include <cstdint>
#include <vector>

namespace dynemo {

enum class KernelType : std::uint8_t {
  kNone = 0,
  kHuber = 1,
  kCauchy = 2,
  kTukey = 3,
  kGemanMcClure = 4
};

const char* kernelName(KernelType type);

struct RobustKernel {
  KernelType type = KernelType::kNone;
  /// Residual norm (in standard deviations) where the kernel starts to bend.
  double width = 1.0;

  struct Value {
    double rho;     ///< ρ(s)
    double weight;  ///< ρ'(s)
  };
  Value operator()(double s) const;
};

}  // namespace dynemo
