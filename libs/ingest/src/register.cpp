#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservation6DFeatures.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CObservationRotatingScan.h>
#include <mrpt/obs/CObservationVelodyneScan.h>

#include "dynemo/ingest/decoders.h"

namespace dynemo {

const Decoders& decoders() {
  // Within a role, in order of preference.
  static const Decoders table = [] {
    Decoders d;
    d.scans.add(CLASS_ID(mrpt::obs::CObservationPointCloud), decodePointCloud);
    d.scans.add(CLASS_ID(mrpt::obs::CObservationVelodyneScan), decodeVelodyneScan);
    d.scans.add(CLASS_ID(mrpt::obs::CObservationRotatingScan), decodeRotatingScan);
    d.scans.add(CLASS_ID(mrpt::obs::CObservation3DRangeScan), decode3DRangeScan);
    d.images.add(CLASS_ID(mrpt::obs::CObservationImage), decodeImage);
    d.images.add(CLASS_ID(mrpt::obs::CObservation3DRangeScan), decode3DRangeScanImage,
                 hasVisibleImage);
    d.odometry.add(CLASS_ID(mrpt::obs::CObservationRobotPose), decodeRobotPose);
    d.odometry.add(CLASS_ID(mrpt::obs::CObservationOdometry), decodeOdometry2D);
    d.detections.add(CLASS_ID(mrpt::obs::CObservation6DFeatures), decode6DFeatures);
    return d;
  }();
  return table;
}

}  // namespace dynemo
