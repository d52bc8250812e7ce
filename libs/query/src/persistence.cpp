#include "dynemo/query/persistence.h"

#include <algorithm>
#include <cmath>

namespace dynemo {

double DeparturePrior::survival(double after_s) const {
  if (gone_by_s) return std::clamp(1.0 - after_s / *gone_by_s, 0.0, 1.0);
  const double beta = residence_s + observed_s;
  return std::pow(beta / (beta + std::max(0.0, after_s)), 1.0 + moves);
}

double presenceProbability(const DeparturePrior& prior, const std::vector<Look>& looks,
                           double after_s) {
  // The looks before d multiply their ratios; those after d cancel out.
  double still_there = 0.0, gone = 0.0, ratio = 1.0, from_s = 0.0;
  const auto add = [&](double a_s, double b_s) {
    const double split_s = std::clamp(after_s, a_s, b_s);
    gone += ratio * (prior.survival(a_s) - prior.survival(split_s));
    still_there += ratio * (prior.survival(split_s) - prior.survival(b_s));
  };
  for (const Look& look : looks) {
    add(from_s, look.after_s);
    from_s = look.after_s;
    ratio *= look.likelihood_ratio;
  }
  // What is left of the prior: d after the last look.
  const double split_s = std::max(after_s, from_s);
  gone += ratio * (prior.survival(from_s) - prior.survival(split_s));
  still_there += ratio * prior.survival(split_s);
  const double all = still_there + gone;
  return all > 0.0 ? still_there / all : 0.0;
}

}  // namespace dynemo
