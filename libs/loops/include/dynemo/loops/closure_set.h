// The closures of a run held against each other.
#pragma once

#include <cstdint>
#include <vector>

#include "dynemo/loops/odometry_chain.h"

namespace dynemo {

/// A relative pose between two keyframes that scan matching measured; earlier < later.
struct Closure {
  std::size_t earlier = 0, later = 0;
  PoseEstimate earlier_later;
};

enum class Agreement : std::uint8_t {
  kSilent,  ///< the odometry between them is too uncertain to tell
  kAgree,
  kContradict
};

struct ConsistencyParams {
  double probability = 0.999;
  /// Factor on the odometry's standard deviations.
  double drift_scale = 3.0;
  double max_chain_sigma_m = 0.3;
};

/// Whether two closures and the odometry between their ends make a loop that is the identity within
/// its covariance (J. Mangelson et al., "Pairwise Consistent Measurement Set Maximization for
/// Robust Multi-robot Map Merging", ICRA 2018).
Agreement compare(const Closure& a, const Closure& b, const OdometryChain& chain,
                  const ConsistencyParams& params);

/// All closures of a run, and the largest set of them without a contradiction. The largest set is
/// sought greedily: of those that contradict others, the one with the most contradictions goes
/// first (then the one that fewest agree with, then the newest), until none is left. Everything is
/// kept, so that a closure that a wrong one kept out comes in when later ones speak for it.
class ClosureSet {
 public:
  explicit ClosureSet(const ConsistencyParams& params) : params_(params) {}

  /// Takes a closure in and compares it with the others. Returns its index.
  std::size_t add(const Closure& closure, const OdometryChain& chain);
  /// Takes no further notice of a closure.
  void discard(std::size_t index) { discarded_[index] = true; }
  bool discarded(std::size_t index) const { return discarded_[index]; }

  std::size_t size() const { return closures_.size(); }
  const Closure& operator[](std::size_t index) const { return closures_[index]; }

  /// Per closure, whether it belongs to the consistent set.
  std::vector<bool> consistent() const;

 private:
  ConsistencyParams params_;
  std::vector<Closure> closures_;
  std::vector<bool> discarded_;
  /// Of each closure with those before it.
  std::vector<std::vector<Agreement>> agreements_;
};

}  // namespace dynemo
