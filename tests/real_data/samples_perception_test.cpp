// Detections and fragments on the sample recordings against their ground truth.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <iostream>

#include "dynemo/core/noise.h"
#include "dynemo/perception/entity_detector.h"
#include "dynemo/perception/perception_params.h"
#include "sample_dataset.h"

namespace dynemo {
namespace {

constexpr double kNear_m = 3.0;
constexpr double kMaxMedianError_m = 0.02;
constexpr double kMinNees = 0.5, kMaxNees = 1.2;  // divided by the six degrees of freedom
constexpr double kMinIou = 0.75;
/// Truth for fragments: points this far outside of the entity's box still belong to it.
constexpr double kBoxMargin_m = 0.03;
constexpr std::size_t kMinPointsInBox = 20;

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values.at(values.size() / 2);
}

PointIndices pointsInBox(const Scan& scan, const Pose3& T_base_entity, const test::EntityBox& box) {
  const Pose3 T_entity_lidar = T_base_entity.inverse() * scan.T_base_lidar;
  PointIndices inside;
  for (std::uint32_t i = 0; i < scan.cloud.size(); ++i) {
    const Vector3 p = T_entity_lidar * scan.cloud.points[i].cast<double>();
    const bool within = (p.array() > box.min.array() - kBoxMargin_m).all() &&
                        (p.array() < box.max.array() + kBoxMargin_m).all();
    // The lowest strip cannot be told from the ground.
    if (within && p.z() > box.min.z() + kBoxMargin_m) inside.push_back(i);
  }
  return inside;
}

double iou(const PointIndices& a, const PointIndices& b) {
  PointIndices common;
  std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(common));
  return static_cast<double>(common.size()) /
         static_cast<double>(a.size() + b.size() - common.size());
}

struct Result {
  std::vector<double> near_error_m, nees, iou;
};

Result evaluate(const std::filesystem::path& folder, const std::string& name,
                const PerceptionParams& params) {
  const EntityModels models = EntityModels::load(folder / (name + "_entities.yaml"));
  const test::SampleTruth truth(folder, name);
  test::SampleFrames frames(folder, name);
  const auto detector = entityDetectors().make("apriltag", params, models);
  FragmentContext context;
  context.models = &models;
  Result result;
  while (const auto frame = frames.next()) {
    const auto observations = detector->detect(*frame);
    const auto fragments =
        frame->scan ? extractFragments(*frame->scan, observations, params.fragments, context)
                    : std::vector<PointIndices>(observations.size());
    for (std::size_t i = 0; i < observations.size(); ++i) {
      const EntityObservation& seen = observations[i];
      const auto T_base_entity = truth.T_base_entity(seen.entity, seen.stamp);
      if (!T_base_entity) continue;
      const Vector6 error = local(*T_base_entity, seen.T_base_entity);
      result.nees.push_back(squaredMahalanobis(error, seen.covariance));
      if (T_base_entity->t.norm() < kNear_m) {
        result.near_error_m.push_back(error.head<3>().norm());
      }
      if (!frame->scan) continue;
      const auto inside = pointsInBox(*frame->scan, *T_base_entity, truth.boxes().at(seen.entity));
      if (inside.size() >= kMinPointsInBox) result.iou.push_back(iou(fragments[i], inside));
    }
  }
  return result;
}

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

class EverySample : public ::testing::TestWithParam<const char*> {};

TEST_P(EverySample, DetectionsAndFragmentsAgreeWithTheTruth) {
  const auto folder = test::samplesFolder();
  if (!folder) GTEST_SKIP() << "DYNEMO_SAMPLES is not set";
  PerceptionParams params;
  params.min_sigma_translation_m = params.min_sigma_rotation_rad = 0.0;  // the noise model alone
  const Result result = evaluate(*folder / GetParam(), GetParam(), params);
  ASSERT_GT(result.near_error_m.size(), 50U);
  const double nees = mean(result.nees) / 6.0;
  RecordProperty("near_median_m", std::to_string(median(result.near_error_m)));
  std::cout << result.nees.size() << " detections; up to 3 m: median error "
            << 1000.0 * median(result.near_error_m) << " mm; NEES/6 " << nees << "; fragments: IoU "
            << mean(result.iou) << "\n";
  EXPECT_LE(median(result.near_error_m), kMaxMedianError_m);
  EXPECT_GT(nees, kMinNees);
  EXPECT_LT(nees, kMaxNees);
  EXPECT_GE(mean(result.iou), kMinIou);
}

INSTANTIATE_TEST_SUITE_P(Samples, EverySample, ::testing::Values("mini_samo", "mini_mamo"));

}  // namespace
}  // namespace dynemo
