#pragma once

#include <mrpt/img/CImage.h>
#include <mrpt/img/TCamera.h>

#include "dynemo/ingest/decoders.h"

namespace dynemo {

/// A camera image from pixels and calibration as MRPT stores them, embedded or in an external file,
/// grey or colour. The stamp is left to the caller. A missing or unlikely calibration is counted;
/// one that is not finite fails.
Expected<CameraImage, DecodeFailure> cameraImage(const mrpt::img::CImage& pixels,
                                                 const mrpt::img::TCamera& calibration,
                                                 const Pose3& T_base_camera,
                                                 const std::string& label,
                                                 const DecodeContext& context);

}  // namespace dynemo
