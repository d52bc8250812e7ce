// Scan matchers on pairs cut from the samples; DYNEMO_SAMPLES names their folder. Prints the table
// of all matchers.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <numbers>
#include <random>

#include "dynemo/ingest/rawlog_source.h"
#include "dynemo/matching/matcher_chain.h"
#include "sample_dataset.h"

namespace dynemo {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr int kPairsPerSample = 20;
constexpr double kNear_m = 1.0, kFar_m = 3.0;
/// Scans closer in time are neighbours on the path, not loops.
constexpr double kMinGap_s = 5.0;

double cpuSeconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct LoopPair {
  Scan target, source;
  Pose3 T_target_source;
};

struct PosedScan {
  Scan scan;
  Pose3 T_world_base;
};

std::vector<PosedScan> posedScans(const std::filesystem::path& samples, const std::string& name) {
  const test::SampleTruth truth(samples / name, name);
  const auto source = makeRawlogSource(IngestParams(), samples / name / (name + ".rawlog"));
  std::vector<PosedScan> scans;
  while (auto frame = source->next()) {
    if (!frame->scan) continue;
    if (const auto T_world_base = truth.T_world_base(frame->scan->stamp))
      scans.push_back({std::move(*frame->scan), *T_world_base});
  }
  return scans;
}

/// Pairs of scans 1 to 3 m apart, drawn at random.
std::vector<LoopPair> loopPairs(const std::filesystem::path& samples, const std::string& name) {
  const std::vector<PosedScan> scans = posedScans(samples, name);
  std::mt19937_64 random(5);
  std::uniform_int_distribution<std::size_t> any(0, scans.size() - 1);
  std::vector<LoopPair> pairs;
  while (pairs.size() < kPairsPerSample) {
    const PosedScan &a = scans[any(random)], &b = scans[any(random)];
    const Pose3 T_a_b = a.T_world_base.inverse() * b.T_world_base;
    const double distance_m = T_a_b.t.norm();
    if (distance_m < kNear_m || distance_m > kFar_m ||
        std::abs(secondsBetween(a.scan.stamp, b.scan.stamp)) < kMinGap_s)
      continue;
    pairs.push_back({a.scan, b.scan, T_a_b});
  }
  return pairs;
}

const std::vector<LoopPair>& allPairs() {
  static const std::vector<LoopPair> all = [] {
    std::vector<LoopPair> pairs;
    for (const std::string name : {"mini_samo", "mini_mamo"}) {
      auto some = loopPairs(*test::samplesFolder(), name);
      pairs.insert(pairs.end(), some.begin(), some.end());
    }
    return pairs;
  }();
  return all;
}

struct InitialError {
  double translation_m, rotation_rad;
};

/// Horizontal and about the vertical for the most part, as drift is.
Pose3 disturbed(const Pose3& T, const InitialError& error, std::mt19937_64& random) {
  std::uniform_real_distribution<double> angle(-std::numbers::pi, std::numbers::pi);
  const double heading = angle(random);
  const double side = angle(random) > 0.0 ? 1.0 : -1.0;
  Vector6 d;
  d << error.translation_m * Vector3(std::cos(heading), std::sin(heading), 0.05).normalized(),
      error.rotation_rad * Vector3(0.05, 0.05, side).normalized();
  return T.retract(d);
}

struct Row {
  int success = 0, pairs = 0;
  std::vector<double> translations_m, rotations_rad;
  double cpu_s = 0.0;

  double rate() const { return static_cast<double>(success) / pairs; }
  static double median(std::vector<double> v) {
    if (v.empty()) return 1e9;
    std::nth_element(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2), v.end());
    return v[v.size() / 2];
  }
  double cpu_ms() const { return 1e3 * cpu_s / pairs; }
};

/// CPU time is of both scans' preparation and the match.
Row measure(const ScanMatcher& matcher, const MatchingParams& params, const InitialError& error) {
  std::mt19937_64 random(17);
  Row row;
  for (const LoopPair& pair : allPairs()) {
    const Pose3 T_guess = disturbed(pair.T_target_source, error, random);
    const double before_s = cpuSeconds();
    const MatchScan target(pair.target, params.scan), source(pair.source, params.scan);
    const auto found = matcher.match(
        target, source, {T_guess, 0.5 * error.translation_m, 0.5 * error.rotation_rad});
    row.cpu_s += cpuSeconds() - before_s;
    ++row.pairs;
    if (!found) continue;
    const Vector6 d = local(pair.T_target_source, found->T_target_source);
    row.translations_m.push_back(d.head<3>().norm());
    row.rotations_rad.push_back(d.tail<3>().norm());
    if (d.head<3>().norm() < 0.10 && d.tail<3>().norm() < 1.0 * kDegree) ++row.success;
  }
  return row;
}

void print(const std::string& name, const InitialError& error, const Row& row) {
  std::printf("  %-32s %.1f m %2.0f deg   %2d of %2d   %7.2f cm %6.3f deg   %6.1f ms\n",
              name.c_str(), error.translation_m, error.rotation_rad / kDegree, row.success,
              row.pairs, 100.0 * Row::median(row.translations_m),
              Row::median(row.rotations_rad) / kDegree, row.cpu_ms());
}

constexpr InitialError kSmall{0.3, 5 * kDegree}, kLarge{1.0, 15 * kDegree};

class SamplePairs : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!test::samplesFolder()) GTEST_SKIP() << "DYNEMO_SAMPLES is not set";
  }
};

TEST_F(SamplePairs, DefaultChain) {
  const MatchingParams params;
  const auto chain = makeScanMatcher(params);
  for (const InitialError& error : {kSmall, kLarge}) {
    const Row row = measure(*chain, params, error);
    print("default chain", error, row);
    EXPECT_GE(row.rate(), 0.95);
    EXPECT_LE(Row::median(row.translations_m), 0.005);
    EXPECT_LE(Row::median(row.rotations_rad), 0.1 * kDegree);
    RecordProperty("cpu_ms", std::to_string(row.cpu_ms()));
  }
}

/// A single matcher, however coarse, must at least come nearer than a small error's guess.
TEST_F(SamplePairs, EveryMatcherAlone) {
  const MatchingParams params;
  for (const std::string& name : scanMatchers().names()) {
    const auto matcher = scanMatchers().make(name, params);
    for (const InitialError& error : {kSmall, kLarge}) {
      const Row row = measure(*matcher, params, error);
      print(name, error, row);
      if (error.translation_m == kSmall.translation_m) {
        EXPECT_LT(Row::median(row.translations_m), 0.15) << name;
        EXPECT_LT(Row::median(row.rotations_rad), 2.5 * kDegree) << name;
      }
    }
  }
}

}  // namespace
}  // namespace dynemo
