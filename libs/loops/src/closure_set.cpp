#include "dynemo/loops/closure_set.h"

#include <algorithm>

#include "independent_set.h"

namespace dynemo {
namespace {

/// Fewer loops do not tell how good the odometry is.
constexpr std::size_t kFewLoops = 10;
/// Of a closure among equals: what speaks for the one that others agree with, and for the older.
constexpr double kAgreementWeight = 1e-2, kAgeWeight = 1e-4;
/// A closure that the graph contradicts.
constexpr double kDoubtWeight = 0.9;
constexpr std::ptrdiff_t kSupport = 2;

PoseEstimate scaled(PoseEstimate estimate, double sigma_factor) {
  estimate.covariance *= sigma_factor * sigma_factor;
  return estimate;
}

double translationVariance(const Matrix6& covariance) {
  return covariance.topLeftCorner<3, 3>().trace();
}

}  // namespace

std::optional<LoopCheck> checkLoop(const Closure& a, const Closure& b, const OdometryChain& chain,
                                   double max_chain_sigma_m) {
  const auto at_start = chain.between(a.earlier, b.earlier, max_chain_sigma_m);
  const auto at_end = chain.between(b.later, a.later, max_chain_sigma_m);
  if (!at_start || !at_end) return std::nullopt;
  LoopCheck check;
  for (std::size_t i = 0; i < LoopCheck::kScales.size(); ++i) {
    const double scale = LoopCheck::kScales[i];
    const PoseEstimate by_b =
        compose(compose(scaled(*at_start, scale), b.earlier_later), scaled(*at_end, scale));
    check.squared_distance[i] = squaredMahalanobis(a.earlier_later, by_b);
  }
  const double closures =
      translationVariance(a.earlier_later.covariance + b.earlier_later.covariance);
  check.tells_odometry =
      translationVariance(at_start->covariance) + translationVariance(at_end->covariance) >
      2.0 * closures;
  return check;
}

std::size_t ClosureSet::add(const Closure& closure, const OdometryChain& chain) {
  const std::size_t index = closures_.size();
  for (std::size_t i = 0; i < index; ++i) {
    if (discarded_[i]) continue;
    const auto check = checkLoop(closures_[i], closure, chain, params_.max_chain_sigma_m);
    if (check) pairs_.push_back({i, index, *check});
  }
  closures_.push_back(closure);
  discarded_.push_back(false);
  doubtful_.push_back(false);
  learnScale();
  return index;
}

std::vector<bool> ClosureSet::removeKeyframe(std::size_t keyframe) {
  std::vector<bool> stays(closures_.size());
  std::vector<std::size_t> moved_to(closures_.size());
  std::size_t kept = 0;
  for (std::size_t i = 0; i < closures_.size(); ++i) {
    Closure closure = closures_[i];
    stays[i] = closure.earlier != keyframe && closure.later != keyframe;
    if (!stays[i]) continue;
    if (closure.earlier > keyframe) --closure.earlier;
    if (closure.later > keyframe) --closure.later;
    closures_[kept] = closure;
    discarded_[kept] = discarded_[i];
    doubtful_[kept] = doubtful_[i];
    moved_to[i] = kept++;
  }
  closures_.resize(kept);
  discarded_.resize(kept);
  doubtful_.resize(kept);
  std::erase_if(pairs_, [&](const Pair& pair) { return !stays[pair.a] || !stays[pair.b]; });
  for (Pair& pair : pairs_) {
    pair.a = moved_to[pair.a];
    pair.b = moved_to[pair.b];
  }
  return stays;
}

void ClosureSet::learnScale() {
  const double expected_median = chiSquaredQuantile(6, 0.5);
  std::vector<const LoopCheck*> telling;
  for (const Pair& pair : pairs_) {
    if (pair.check.tells_odometry) telling.push_back(&pair.check);
  }
  scale_ = LoopCheck::kScales.size() - 1;
  if (telling.size() < kFewLoops) return;
  for (std::size_t scale = 0; scale < LoopCheck::kScales.size(); ++scale) {
    const auto within = std::count_if(telling.begin(), telling.end(), [&](const LoopCheck* check) {
      return check->squared_distance[scale] <= expected_median;
    });
    if (2 * static_cast<std::size_t>(within) < telling.size()) continue;
    scale_ = scale;
    return;
  }
}

bool ClosureSet::contradict(const Pair& pair) const {
  return pair.check.squared_distance[scale_] > chiSquaredQuantile(6, params_.probability);
}

std::vector<bool> ClosureSet::consistent() const {
  const std::size_t n = closures_.size();
  std::vector<std::vector<std::size_t>> conflicts(n), agreements(n);
  for (const Pair& pair : pairs_) {
    if (discarded_[pair.a] || discarded_[pair.b]) continue;
    auto& lists = contradict(pair) ? conflicts : agreements;
    lists[pair.a].push_back(pair.b);
    lists[pair.b].push_back(pair.a);
  }
  std::vector<double> weights(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double age = static_cast<double>(i) / static_cast<double>(n);
    const double share = static_cast<double>(agreements[i].size()) / static_cast<double>(n);
    weights[i] = discarded_[i] ? 0.0 : 1.0 + kAgreementWeight * share - kAgeWeight * age;
    if (doubtful_[i]) weights[i] *= kDoubtWeight;
  }
  std::vector<bool> in = heaviestIndependentSet(conflicts, weights);
  for (std::size_t i = 0; i < n; ++i) {
    if (discarded_[i]) in[i] = false;
    if (!in[i] || !doubtful_[i]) continue;
    const auto support = std::count_if(agreements[i].begin(), agreements[i].end(),
                                       [&](std::size_t k) { return in[k]; });
    in[i] = support >= kSupport;
  }
  return in;
}

}  // namespace dynemo
