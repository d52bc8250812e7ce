// The closures of a run held against each other.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "dynemo/loops/odometry_chain.h"

namespace dynemo {

/// A relative pose between two keyframes that scan matching measured; earlier < later.
struct Closure {
  std::size_t earlier = 0, later = 0;
  PoseEstimate earlier_later;
};

struct ConsistencyParams {
  double probability = 0.999;
  /// Upper limit of the factor on the odometry's standard deviations.
  double max_drift_scale = 3.0;
  double max_chain_sigma_m = 0.3;
};

/// How well two closures and the odometry between their ends make a loop that is the identity.
struct LoopCheck {
  /// Factors on the odometry's standard deviations.
  static constexpr std::array<double, 5> kScales = {1.0, 1.25, 1.6, 2.2, 3.0};
  /// Squared Mahalanobis distance from the identity at each of them.
  std::array<double, kScales.size()> squared_distance{};
  /// Whether the odometry is the larger part of the covariance.
  bool tells_odometry = false;
};

/// Empty where the odometry between the two is too uncertain to say anything (J. Mangelson et al.,
/// "Pairwise Consistent Measurement Set Maximization for Robust Multi-robot Map Merging", ICRA
/// 2018).
std::optional<LoopCheck> checkLoop(const Closure& a, const Closure& b, const OdometryChain& chain,
                                   double max_chain_sigma_m);

/// All closures of a run, and the largest set of them without a contradiction; of equal ones the
/// one whose members more others agree with, then the older. Everything is kept, so that a closure
/// that a wrong one kept out comes in when later ones speak for it.
///
/// Odometry may be worse than its covariance says. By how much, the loops themselves tell: half of
/// them must be within the median of χ². While there are few, the limit is assumed.
class ClosureSet {
 public:
  explicit ClosureSet(const ConsistencyParams& params) : params_(params) {}

  /// Takes a closure in and compares it with the others. Returns its index.
  std::size_t add(const Closure& closure, const OdometryChain& chain);
  /// From now on the closure belongs to the set only where at least two members agree with it.
  void doubt(std::size_t index) { doubtful_[index] = true; }
  /// A keyframe leaves the graph: its closures leave the set, and keyframes after it count one less.
  /// Returns, per closure there was, whether it stays; indices of those that do close up.
  std::vector<bool> removeKeyframe(std::size_t keyframe);
  /// Takes no further notice of a closure.
  void discard(std::size_t index) { discarded_[index] = true; }
  bool discarded(std::size_t index) const { return discarded_[index]; }

  std::size_t size() const { return closures_.size(); }
  const Closure& operator[](std::size_t index) const { return closures_[index]; }

  /// Per closure, whether it belongs to the consistent set.
  std::vector<bool> consistent() const;
  /// Factor on the odometry's standard deviations that the loops speak for, at least 1.
  double driftScale() const {
    return std::min(LoopCheck::kScales[scale_], params_.max_drift_scale);
  }

 private:
  struct Pair {
    std::size_t a = 0, b = 0;
    LoopCheck check;
  };
  void learnScale();
  bool contradict(const Pair& pair) const;

  ConsistencyParams params_;
  std::vector<Closure> closures_;
  std::vector<bool> discarded_, doubtful_;
  std::vector<Pair> pairs_;  ///< those that say something
  std::size_t scale_ = LoopCheck::kScales.size() - 1;
};

}  // namespace dynemo
