// The visible image of a depth camera, CObservation3DRangeScan.
#include <mrpt/obs/CObservation3DRangeScan.h>

#include "camera_image.h"
#include "dynemo/core/mrpt_conversions.h"
#include "dynemo/ingest/decoders.h"

namespace dynemo {

using mrpt::obs::CObservation3DRangeScan;

bool hasVisibleImage(const mrpt::obs::CObservation& observation) {
  const auto& o = dynamic_cast<const CObservation3DRangeScan&>(observation);
  return o.hasIntensityImage && o.intensityImageChannel == CObservation3DRangeScan::CH_VISIBLE;
}

Expected<CameraImage, DecodeFailure> decode3DRangeScanImage(mrpt::obs::CObservation& observation,
                                                            const DecodeContext& context) {
  const auto& o = dynamic_cast<const CObservation3DRangeScan&>(observation);
  const auto T_base_depth = sensorPose(o, context);
  if (!T_base_depth) return make_unexpected(T_base_depth.error());
  const Pose3 T_depth_camera = fromMrpt(o.relativePoseIntensityWRTDepth);
  if (!isPlausible(T_depth_camera)) return make_unexpected("the sensor pose is not plausible");
  return cameraImage(o.intensityImage, o.cameraParamsIntensity, *T_base_depth * T_depth_camera,
                     o.sensorLabel, context);
}

}  // namespace dynemo
