// How accurate whole runs are, judged by dynemo-eval against ground truth.
#include <gtest/gtest.h>

#include "slam_run.h"

namespace dynemo::test {
namespace {

struct Bounds {
  double ate_m = 0.0;
  double placement_median_m = 0.0, placement_worst_m = 0.0;
};

/// Without anything to correct it by, a trajectory is its odometry up to interpolation.
constexpr double kSameAsOdometry_m = 1e-3;

void expectObjectsWithin(const nlohmann::json& evaluation, const Bounds& bounds) {
  const auto& position =
      evaluation.at("entities").at("object_placements").at("last").at("translation_m");
  EXPECT_LE(position.at("median").get<double>(), bounds.placement_median_m);
  EXPECT_LE(position.at("max").get<double>(), bounds.placement_worst_m);
}

using Counts = std::vector<const char*>;

/// Every moved object reported, none of the static ones, at the right observation.
void expectMotionsReported(const nlohmann::json& evaluation,
                           const Counts& of = {"moved_by_object", "moved_by_observation",
                                               "objects_at_end"}) {
  const auto& changes = evaluation.at("entities").at("changes");
  for (const char* counts : of) {
    SCOPED_TRACE(counts);
    EXPECT_GT(changes.at(counts).at("true_positives"), 0);
    EXPECT_EQ(changes.at(counts).at("precision"), 1.0);
    EXPECT_EQ(changes.at(counts).at("recall"), 1.0);
  }
}

void expectWithin(const SlamRun& run, const Dataset& dataset, const Bounds& bounds) {
  ASSERT_TRUE(run.ok()) << describe(run.outcome());
  const nlohmann::json evaluation = run.evaluate();
  EXPECT_LE(ate(evaluation), bounds.ate_m);
  expectObjectsWithin(evaluation, bounds);
  expectMotionsReported(evaluation);
  EXPECT_EQ(run.movedObjects(), displacedObjects(dataset));
}

TEST(BundledSample, FullCorrectsTheOdometryAndFindsWhatMoved) {
  expectWithin(bundledRun("full"), bundledSample(), {0.009, 0.005, 0.015});
}

TEST(BundledSample, FullIsBetterThanTheBaseline) {
  // Both have walls and floors; the entities and their keyframes make the difference.
  EXPECT_LT(ate(bundledRun("full").evaluate()), 0.65 * ate(bundledRun("baseline").evaluate()));
}

TEST(BundledSample, LidarOdometryReachesMillimetres) {
  const SlamRun run(bundledSample(), {"--setup", "full", "--set", "odometry.source=lidar"});
  expectWithin(run, bundledSample(), {0.005, 0.0035, 0.0145});
}

/// One of its chairs is put elsewhere out of sight, and nobody looks there again.
TEST(HallSample, FullCorrectsHandHeldMotionAndFindsWhatMoved) {
  const SlamRun run(hallSample(), {"--setup", "full", "--config",
                                   (hallSample().folder / "hall_config.yaml").string()});
  ASSERT_TRUE(run.ok()) << describe(run.outcome());
  const nlohmann::json evaluation = run.evaluate();
  EXPECT_LE(ate(evaluation), 0.009);
  expectObjectsWithin(evaluation, {0.009, 0.006, 0.015});
  expectMotionsReported(evaluation, {"moved_by_object", "moved_by_observation"});
}

class SetupAccuracy : public testing::TestWithParam<const char*> {};

TEST_P(SetupAccuracy, NeverWorseThanTheOdometryAlone) {
  const nlohmann::json evaluation = bundledRun(GetParam()).evaluate();
  EXPECT_LE(ate(evaluation), ate(evaluation, "odometry") + kSameAsOdometry_m);
}

INSTANTIATE_TEST_SUITE_P(AllSetups, SetupAccuracy,
                         testing::Values("baseline", "only-kf-e", "intra-e", "f-e", "fcs",
                                         "always-epcr", "mb-epcr", "full"));

/// The datasets in the folder that DYNEMO_SAMPLES names.
struct SampleCase {
  const char* name;
  Bounds rawlog_odometry, lidar_odometry;
};

class Sample : public testing::TestWithParam<SampleCase> {
 protected:
  void SetUp() override {
    const auto dataset = sample(GetParam().name);
    if (!dataset) GTEST_SKIP() << "DYNEMO_SAMPLES does not name the folder of the sample datasets";
    dataset_ = *dataset;
  }
  Dataset dataset_;
};

TEST_P(Sample, FullWithTheOdometryOfTheLog) {
  const SlamRun full(dataset_, {"--setup", "full"}), baseline(dataset_, {"--setup", "baseline"});
  expectWithin(full, dataset_, GetParam().rawlog_odometry);
  ASSERT_TRUE(baseline.ok()) << describe(baseline.outcome());
  EXPECT_LE(ate(full.evaluate()), ate(baseline.evaluate()));
}

TEST_P(Sample, FullWithLidarOdometry) {
  const SlamRun run(dataset_, {"--setup", "full", "--set", "odometry.source=lidar"});
  expectWithin(run, dataset_, GetParam().lidar_odometry);
}

INSTANTIATE_TEST_SUITE_P(
    Simulated, Sample,
    testing::Values(SampleCase{"mini_samo", {0.010, 0.004, 0.008}, {0.005, 0.005, 0.015}},
                    SampleCase{"mini_mamo", {0.010, 0.005, 0.010}, {0.005, 0.005, 0.02}}),
    [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace dynemo::test
