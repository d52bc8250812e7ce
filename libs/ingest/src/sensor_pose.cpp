#include "dynemo/core/mrpt_conversions.h"
#include "dynemo/ingest/decoders.h"

namespace dynemo {

Expected<Pose3, DecodeFailure> sensorPose(const mrpt::obs::CObservation& observation,
                                          const DecodeContext& context) {
  const auto it = context.extrinsics.find(observation.sensorLabel);
  if (it != context.extrinsics.end()) return it->second;
  mrpt::poses::CPose3D pose;
  observation.getSensorPose(pose);
  const Pose3 T_base_sensor = fromMrpt(pose);
  if (!T_base_sensor.isFinite()) return make_unexpected("the sensor pose is not finite");
  return T_base_sensor.normalized();
}

}  // namespace dynemo
