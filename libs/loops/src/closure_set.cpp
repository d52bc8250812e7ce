#include "dynemo/loops/closure_set.h"

#include <tuple>

namespace dynemo {
namespace {

PoseEstimate scaled(PoseEstimate estimate, double sigma_factor) {
  estimate.covariance *= sigma_factor * sigma_factor;
  return estimate;
}

}  // namespace

Agreement compare(const Closure& a, const Closure& b, const OdometryChain& chain,
                  const ConsistencyParams& params) {
  const auto at_start = chain.between(a.earlier, b.earlier, params.max_chain_sigma_m);
  const auto at_end = chain.between(b.later, a.later, params.max_chain_sigma_m);
  if (!at_start || !at_end) return Agreement::kSilent;
  const PoseEstimate by_b = compose(compose(scaled(*at_start, params.drift_scale), b.earlier_later),
                                    scaled(*at_end, params.drift_scale));
  return squaredMahalanobis(a.earlier_later, by_b) <= chiSquaredQuantile(6, params.probability)
             ? Agreement::kAgree
             : Agreement::kContradict;
}

std::size_t ClosureSet::add(const Closure& closure, const OdometryChain& chain) {
  std::vector<Agreement> with_others;
  for (std::size_t i = 0; i < closures_.size(); ++i) {
    with_others.push_back(discarded_[i] ? Agreement::kSilent
                                        : compare(closure, closures_[i], chain, params_));
  }
  closures_.push_back(closure);
  discarded_.push_back(false);
  agreements_.push_back(std::move(with_others));
  return closures_.size() - 1;
}

std::vector<bool> ClosureSet::consistent() const {
  const std::size_t n = closures_.size();
  std::vector<bool> in(n);
  std::vector<int> contradictions(n, 0), agreements(n, 0);
  const auto between = [&](std::size_t i, std::size_t j) {
    return agreements_[std::max(i, j)][std::min(i, j)];
  };
  for (std::size_t i = 0; i < n; ++i) in[i] = !discarded_[i];
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (!in[i] || !in[j] || between(i, j) == Agreement::kSilent) continue;
      auto& counts = between(i, j) == Agreement::kAgree ? agreements : contradictions;
      ++counts[i];
      ++counts[j];
    }
  }
  while (true) {
    std::size_t worst = n;
    for (std::size_t i = 0; i < n; ++i) {
      if (!in[i] || contradictions[i] == 0) continue;
      const auto key = [&](std::size_t k) { return std::tuple(contradictions[k], -agreements[k]); };
      if (worst == n || key(i) >= key(worst)) worst = i;
    }
    if (worst == n) return in;
    in[worst] = false;
    for (std::size_t i = 0; i < n; ++i) {
      if (i == worst || !in[i]) continue;
      if (between(i, worst) == Agreement::kContradict) --contradictions[i];
      if (between(i, worst) == Agreement::kAgree) --agreements[i];
    }
  }
}

}  // namespace dynemo
