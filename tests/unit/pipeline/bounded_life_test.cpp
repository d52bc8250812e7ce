// A robot that drives the same circle again and again, with and without a bounded life.
#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "dynemo/evaluation/alignment.h"
#include "frames.h"

namespace dynemo {
namespace {

constexpr int kFramesPerLap = 100, kLaps = 10, kObjects = 10;
constexpr double kRadius_m = 4.0, kView_m = 5.0;
/// The object that is carried off after this lap.
constexpr int kMoved = 3, kMovedAfterLap = 5;

Pose3 truth(int frame) {
  const double turn = 2.0 * std::numbers::pi * frame / kFramesPerLap;
  return Pose3::fromYawPitchRoll(kRadius_m * std::cos(turn), kRadius_m * std::sin(turn), 0,
                                 turn + 0.5 * std::numbers::pi, 0, 0);
}

Pose3 objectAt(int object, int frame) {
  const double turn = 2.0 * std::numbers::pi * object / kObjects;
  const bool moved = object == kMoved && frame >= kMovedAfterLap * kFramesPerLap;
  const double r = kRadius_m + 1.5 + (moved ? 1.0 : 0.0);
  return Pose3::fromYawPitchRoll(r * std::cos(turn), r * std::sin(turn), 0.3, turn, 0, 0);
}

class Noise {
 public:
  Pose3 on(const Pose3& T, double sigma_m, double sigma_rad) {
    Vector6 d;
    for (int i = 0; i < 6; ++i) d[i] = (i < 3 ? sigma_m : sigma_rad) * gauss();
    return T.retract(d);
  }

 private:
  double gauss() {
    double sum = -6.0;
    for (int i = 0; i < 12; ++i) sum += static_cast<double>(rng_() >> 11) * 0x1.0p-53;
    return sum;
  }
  std::mt19937_64 rng_{5};
};

class Laps : public testing::Test {
 protected:
  /// Each once for all tests.
  static void SetUpTestSuite() {
    unbounded_ = drive(params(false));
    most_keyframes_ = 0;
    bounded_ = drive(params(true));
  }
  static void TearDownTestSuite() {
    unbounded_.reset();
    bounded_.reset();
  }
  static DynemoParams params(bool bounded) {
    DynemoParams params = test::externalOnly();
    params.life.bounded = bounded;
    params.life.window = 30;
    params.life.batch = 5;
    return params;
  }

  static std::unique_ptr<SlamPipeline> drive(const DynemoParams& params) {
    auto pipeline = std::make_unique<SlamPipeline>(params, models_, true);
    Noise noise;
    Pose3 T_odom_base;
    for (int i = 0; i < kLaps * kFramesPerLap; ++i) {
      if (i > 0)
        T_odom_base = T_odom_base * noise.on(truth(i - 1).inverse() * truth(i), 0.004, 0.002);
      SensorFrame frame = test::frameAt(0.25 * i, T_odom_base);
      frame.index = static_cast<std::uint64_t>(i);
      for (int object = 0; object < kObjects; ++object) {
        const Pose3 T_base_entity = truth(i).inverse() * objectAt(object, i);
        if (T_base_entity.t.norm() > kView_m || T_base_entity.t.x() < 0) continue;
        test::see(frame, object, noise.on(T_base_entity, 0.005, 0.005));
      }
      test::process(*pipeline, std::move(frame));
      most_keyframes_ = std::max(most_keyframes_, pipeline->graph().keyframes().size());
    }
    pipeline->finish();
    return pipeline;
  }

  static double ate_m(const SlamPipeline& pipeline) {
    std::vector<Vector3> reference, estimate;
    for (std::size_t i = 0; i < pipeline.frames().size(); ++i) {
      reference.push_back(truth(static_cast<int>(i)).t);
      estimate.push_back(pipeline.frames()[i].T_map_base.t);
    }
    const auto T = alignPoints(reference, estimate);
    double sum = 0.0;
    for (std::size_t i = 0; i < reference.size(); ++i)
      sum += (reference[i] - *T * estimate[i]).squaredNorm();
    return std::sqrt(sum / static_cast<double>(reference.size()));
  }

  static int movesOf(const SlamPipeline& pipeline, std::int64_t object) {
    const auto& track = pipeline.graph().tracks().at({object});
    return static_cast<int>(
        std::count_if(track.begin(), track.end(), [](const auto& node) { return node->moved; }));
  }

  static inline const EntityModels models_;
  static inline std::unique_ptr<SlamPipeline> unbounded_, bounded_;
  static inline std::size_t most_keyframes_ = 0;
};

TEST_F(Laps, KeyframesAreBoundedAndTheTrajectoryIsAsGood) {
  const std::size_t all = unbounded_->graph().keyframes().size();
  EXPECT_EQ(unbounded_->keyframesLeft(), 0u);
  EXPECT_LT(most_keyframes_, all / 2);
  EXPECT_GT(bounded_->keyframesLeft(), all / 2);
  EXPECT_LT(bounded_->graph().edgeCount(), unbounded_->graph().edgeCount() / 2);
  // Every frame has a pose, also those between keyframes that have left.
  ASSERT_EQ(bounded_->frames().size(), unbounded_->frames().size());
  const double on_m = ate_m(*bounded_), off_m = ate_m(*unbounded_);
  RecordProperty("ate_bounded_mm", std::to_string(1e3 * on_m));
  RecordProperty("ate_unbounded_mm", std::to_string(1e3 * off_m));
  EXPECT_LT(on_m, 1.15 * off_m);
}

TEST_F(Laps, WhatMovedIsStillKnown) {
  ASSERT_EQ(bounded_->graph().tracks().size(), static_cast<std::size_t>(kObjects));
  ASSERT_EQ(movesOf(*unbounded_, kMoved), 1);
  for (int object = 0; object < kObjects; ++object)
    EXPECT_EQ(movesOf(*bounded_, object), object == kMoved ? 1 : 0) << object;
  const CNodeEntity* last = bounded_->graph().lastObservation({kMoved});
  const Pose3& T_map_other = bounded_->graph().lastObservation({kMoved + 1})->T_map_entity();
  const Pose3 expected = objectAt(kMoved + 1, 999).inverse() * objectAt(kMoved, 999);
  EXPECT_LT(((T_map_other.inverse() * last->T_map_entity()).t - expected.t).norm(), 0.05);
}

TEST_F(Laps, TwoRunsAreEqual) {
  const auto again = drive(params(true));
  ASSERT_EQ(bounded_->frames().size(), again->frames().size());
  for (std::size_t i = 0; i < again->frames().size(); ++i) {
    EXPECT_EQ(bounded_->frames()[i].T_map_base.t, again->frames()[i].T_map_base.t);
    EXPECT_EQ(bounded_->frames()[i].T_map_base.R, again->frames()[i].T_map_base.R);
  }
}

}  // namespace
}  // namespace dynemo
