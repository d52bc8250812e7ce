// Accuracy on the sample recordings; DYNEMO_SAMPLES names their folder.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "dynemo/ingest/rawlog_source.h"
#include "dynemo/odometry/odometry_params.h"
#include "dynemo/odometry/scan_odometry.h"
#include "synthetic_world.h"

namespace dynemo {
namespace {

namespace fs = std::filesystem;

std::map<Stamp, Pose3> readTum(const fs::path& file) {
  std::map<Stamp, Pose3> poses;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    std::istringstream text(line);
    std::string stamp;
    double x, y, z, qx, qy, qz, qw;
    if (text >> stamp >> x >> y >> z >> qx >> qy >> qz >> qw) {
      poses[Stamp::parse(stamp)] = Pose3(Eigen::Quaterniond(qw, qx, qy, qz), {x, y, z});
    }
  }
  return poses;
}

/// The true pose at the nearest time; they are written at every stamp.
Pose3 poseAt(const std::map<Stamp, Pose3>& poses, Stamp stamp) {
  auto after = poses.lower_bound(stamp);
  if (after == poses.end()) return poses.rbegin()->second;
  if (after == poses.begin()) return after->second;
  const auto before = std::prev(after);
  return stamp.ns - before->first.ns < after->first.ns - stamp.ns ? before->second : after->second;
}

class SampleOdometry : public ::testing::TestWithParam<std::string> {};

TEST_P(SampleOdometry, LocalMapFromConstantVelocityAlone) {
  const char* folder = std::getenv("DYNEMO_SAMPLES");
  if (folder == nullptr) GTEST_SKIP() << "DYNEMO_SAMPLES is not set";
  const fs::path base = fs::path(folder) / GetParam() / GetParam();
  const auto truth = readTum(base.string() + "_gt_robot.tum");
  ASSERT_FALSE(truth.empty());
  const auto source = makeRawlogSource(IngestParams(), base.string() + ".rawlog");
  const auto odometry = scanOdometries().make("local_map", OdometryParams());
  std::vector<Pose3> actual, expected;
  while (const auto frame = source->next()) {
    if (!frame->scan) continue;
    const auto estimate = odometry->update(*frame->scan, std::nullopt);
    ASSERT_TRUE(estimate) << toString(estimate.error()) << " at " << frame->stamp.text();
    actual.push_back(estimate->T_odom_base);
    expected.push_back(poseAt(truth, estimate->stamp));
  }
  ASSERT_GT(actual.size(), 200U);
  constexpr double kMaxAte_m = 0.005;
  const double ate_m = test::absoluteTrajectoryError(expected, actual);
  RecordProperty("ate_mm", std::to_string(1000.0 * ate_m));
  EXPECT_LT(ate_m, kMaxAte_m);
}

INSTANTIATE_TEST_SUITE_P(All, SampleOdometry, ::testing::Values("mini_samo", "mini_mamo"));

}  // namespace
}  // namespace dynemo
