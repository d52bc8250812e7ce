// CObservation6DFeatures: entity poses in the sensor frame, with the entity id as the feature id.
#include <mrpt/obs/CObservation6DFeatures.h>

#include "dynemo/core/mrpt_conversions.h"
#include "dynemo/core/noise.h"
#include "dynemo/ingest/decoders.h"

namespace dynemo {
namespace {

using Measurement = mrpt::obs::CObservation6DFeatures::TMeasurement;

/// MRPT's information matrices are of (x, y, z, yaw, pitch, roll); all zeros means that there is
/// none.
std::optional<Matrix6> covarianceOf(const Measurement& m, const Pose3& T_sensor_entity,
                                    const DecodeContext& context) {
  const Matrix6 information = m.inf_matrix.asEigen().eval();
  if (information.isZero(0.0)) return std::nullopt;
  const auto ypr = information.allFinite() ? invertSpd(information) : std::nullopt;
  if (!ypr) {
    context.warnings.count("detection: information matrix that is not positive definite ignored");
    return std::nullopt;
  }
  mrpt::math::CMatrixDouble66 cov;
  cov.asEigen() = *ypr;
  return covarianceFromMrpt(T_sensor_entity, cov);
}

}  // namespace

Expected<std::vector<ExternalDetection>, DecodeFailure> decode6DFeatures(
    mrpt::obs::CObservation& observation, const DecodeContext& context) {
  const auto& o = dynamic_cast<const mrpt::obs::CObservation6DFeatures&>(observation);
  const auto T_base_sensor = sensorPose(o, context);
  if (!T_base_sensor) return make_unexpected(T_base_sensor.error());
  std::vector<ExternalDetection> detections;
  for (const Measurement& m : o.sensedFeatures) {
    const Pose3 T_sensor_entity = fromMrpt(m.pose);
    if (m.id < 0 || !isPlausible(T_sensor_entity)) {
      context.warnings.count("detection: without id or without plausible pose, dropped");
      continue;
    }
    ExternalDetection d;
    d.entity = EntityId{m.id};
    d.T_base_entity = (*T_base_sensor * T_sensor_entity).normalized();
    // The right tangent does not change when the pose is moved to another parent frame.
    d.covariance = covarianceOf(m, T_sensor_entity, context);
    d.sensor_label = o.sensorLabel;
    detections.push_back(std::move(d));
  }
  return detections;
}

}  // namespace dynemo
