#include "dynemo/core/mrpt_conversions.h"
#include "dynemo/ingest/decoders.h"

namespace dynemo {
namespace {
constexpr double kFarthest_m = 1e8;
constexpr double kRotationTolerance = 1e-2;
}  // namespace

bool isPlausible(const Pose3& pose) {
  if (!pose.isFinite() || pose.t.cwiseAbs().maxCoeff() > kFarthest_m) return false;
  const Matrix3 defect = pose.R.transpose() * pose.R - Matrix3::Identity();
  return defect.norm() < kRotationTolerance;
}

Expected<Pose3, DecodeFailure> sensorPose(const mrpt::obs::CObservation& observation,
                                          const DecodeContext& context) {
  const auto it = context.extrinsics.find(observation.sensorLabel);
  if (it != context.extrinsics.end()) return it->second;
  mrpt::poses::CPose3D pose;
  observation.getSensorPose(pose);
  const Pose3 T_base_sensor = fromMrpt(pose);
  if (!isPlausible(T_base_sensor)) return make_unexpected("the sensor pose is not plausible");
  return T_base_sensor.normalized();
}

}  // namespace dynemo
