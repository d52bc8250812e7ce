// CObservationImage, grey or colour, embedded or in an external file.
#include <mrpt/obs/CObservationImage.h>

#include "camera_image.h"
#include "dynemo/ingest/decoders.h"

namespace dynemo {

Expected<CameraImage, DecodeFailure> decodeImage(mrpt::obs::CObservation& observation,
                                                 const DecodeContext& context) {
  const auto& o = dynamic_cast<const mrpt::obs::CObservationImage&>(observation);
  const auto T_base_camera = sensorPose(o, context);
  if (!T_base_camera) return make_unexpected(T_base_camera.error());
  return cameraImage(o.image, o.cameraParams, *T_base_camera, o.sensorLabel, context);
}

}  // namespace dynemo
