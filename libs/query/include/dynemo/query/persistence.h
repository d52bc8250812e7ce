// How likely an object is still where it was, from the time that went by and from the scans that
// looked at its place. The object leaves at an unknown time d; each look was before or after it:
//   P(d > T | looks) ∝ Σ over the intervals between looks of P(d in the interval) · Π P(look | d)
// as in the persistence filter of D. Rosen, J. Mason, J. Leonard, "Towards lifelong feature-based
// mapping in semi-static environments" (ICRA 2016), with the prior below.
#pragma once

#include <optional>
#include <vector>

namespace dynemo {

/// One look at the place, in seconds after the object was last seen there.
struct Look {
  double after_s = 0.0;
  /// P(what was seen | the object is there) / P(what was seen | it is gone).
  double likelihood_ratio = 1.0;
};

/// When an object leaves, by what is known before any look.
struct DeparturePrior {
  /// Leaving is a Poisson process of unknown rate; its Gamma posterior after `moves` in
  /// `observed_s` is Gamma(1 + moves, residence_s + observed_s).
  double moves = 0.0;
  double residence_s = 3600.0;
  double observed_s = 0.0;
  /// The object was seen elsewhere after so many seconds: it left before, at any time with the same
  /// probability.
  std::optional<double> gone_by_s;

  /// P(d > t): (β / (β + t))^α of the Gamma posterior, or 1 − t / gone_by.
  double survival(double after_s) const;
};

/// P(d > after_s), given the looks (ascending in time).
double presenceProbability(const DeparturePrior& prior, const std::vector<Look>& looks,
                           double after_s);

}  // namespace dynemo
