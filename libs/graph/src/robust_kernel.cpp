#include "dynemo/graph/robust_kernel.h"

#include <cmath>

namespace dynemo {

const char* kernelName(KernelType type) {
  switch (type) {
    case KernelType::kHuber:
      return "huber";
    case KernelType::kCauchy:
      return "cauchy";
    case KernelType::kTukey:
      return "tukey";
    case KernelType::kGemanMcClure:
      return "geman_mcclure";
    case KernelType::kNone:
      break;
  }
  return "none";
}

RobustKernel::Value RobustKernel::operator()(double s) const {
  const double w2 = width * width;
  switch (type) {
    case KernelType::kHuber: {
      if (s <= w2) return {s, 1.0};
      const double r = std::sqrt(s);
      return {2.0 * width * r - w2, width / r};
    }
    case KernelType::kCauchy:
      return {w2 * std::log1p(s / w2), 1.0 / (1.0 + s / w2)};
    case KernelType::kTukey: {
      const double x = s / w2;
      if (x >= 1.0) return {w2 / 3.0, 0.0};
      // w²/3 (1 − (1 − x)³), without cancellation for small x.
      return {s * (1.0 - x + x * x / 3.0), (1.0 - x) * (1.0 - x)};
    }
    case KernelType::kGemanMcClure: {
      const double u = w2 / (w2 + s);
      return {s * u, u * u};
    }
    case KernelType::kNone:
      break;
  }
  return {s, 1.0};
}

}  // namespace dynemo
