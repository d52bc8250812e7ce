#include "dynemo/query/persistence.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace dynemo::test {
namespace {

/// P(d > t | looks) by brute force: the departure on a fine grid, the looks' likelihoods one by
/// one.
double onGrid(const DeparturePrior& prior, const std::vector<Look>& looks, double t) {
  constexpr double kEnd_s = 2e3, kStep_s = 0.02;
  double there = 0.0, all = 0.0;
  const auto weigh = [&](double d, double mass) {
    double likelihood = 1.0;
    for (const Look& look : looks) likelihood *= d > look.after_s ? look.likelihood_ratio : 1.0;
    all += mass * likelihood;
    if (d > t) there += mass * likelihood;
  };
  for (double s = 0.0; s < kEnd_s; s += kStep_s)
    weigh(s + 0.5 * kStep_s, prior.survival(s) - prior.survival(s + kStep_s));
  weigh(2.0 * kEnd_s, prior.survival(kEnd_s));
  return there / all;
}

TEST(Persistence, WithoutLooksIsThePrior) {
  DeparturePrior prior;
  prior.residence_s = 100.0;
  EXPECT_DOUBLE_EQ(presenceProbability(prior, {}, 0.0), 1.0);
  EXPECT_DOUBLE_EQ(presenceProbability(prior, {}, 100.0), 0.5);
  prior.moves = 1.0;
  EXPECT_DOUBLE_EQ(presenceProbability(prior, {}, 100.0), 0.25);
  prior.observed_s = 100.0;
  EXPECT_DOUBLE_EQ(presenceProbability(prior, {}, 200.0), 0.25);
}

TEST(Persistence, AnObjectSeenElsewhereLeftBefore) {
  DeparturePrior prior;
  prior.gone_by_s = 10.0;
  EXPECT_DOUBLE_EQ(presenceProbability(prior, {}, 2.5), 0.75);
  EXPECT_DOUBLE_EQ(presenceProbability(prior, {}, 10.0), 0.0);
  // A look that finds the place empty half-way leaves the first half.
  EXPECT_LT(presenceProbability(prior, {{5.0, 1e-6}}, 5.0), 1e-5);
  EXPECT_NEAR(presenceProbability(prior, {{5.0, 1e-6}}, 2.5), 0.5, 1e-5);
}

TEST(Persistence, LooksCountWhateverTheTimeOfTheQuestion) {
  DeparturePrior prior;
  prior.residence_s = 100.0;
  const double unseen = presenceProbability(prior, {}, 50.0);
  // Occupied later: it was there before. Empty later: it may have left before.
  EXPECT_GT(presenceProbability(prior, {{80.0, 20.0}}, 50.0), unseen);
  EXPECT_LT(presenceProbability(prior, {{80.0, 0.05}}, 50.0), unseen);
}

TEST(Persistence, AgreesWithBruteForce) {
  std::mt19937 rng(7);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (int round = 0; round < 8; ++round) {
    DeparturePrior prior;
    prior.residence_s = 50.0 + 100.0 * uniform(rng);
    prior.moves = round % 3;
    if (round % 2 == 1) prior.gone_by_s = 60.0;
    std::vector<Look> looks;
    for (double t = 10.0 * uniform(rng); t < 50.0; t += 5.0 + 10.0 * uniform(rng)) {
      looks.push_back({t, uniform(rng) < 0.5 ? 0.1 : 6.0});
    }
    const double t = 60.0 * uniform(rng);
    EXPECT_NEAR(presenceProbability(prior, looks, t), onGrid(prior, looks, t), 1e-3);
  }
}

}  // namespace
}  // namespace dynemo::test
