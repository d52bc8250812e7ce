// ROS messages as MRPT objects; no stamps, labels or mounting, which the caller knows.
#pragma once

#include <mrpt/img/TCamera.h>
#include <mrpt/maps/CPointsMap.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>

#include <opencv2/core/mat.hpp>

#include "bag_reader.h"
#include "dynemo/core/error.h"
#include "dynemo/core/se3.h"

namespace dynemo {

Pose3 poseFrom(const ros1::Pose& pose);

/// The points that are finite; a CPointsMapXYZI when there is a field "intensity". Fails, saying
/// why, when x, y or z are missing or of an unknown type, or the data is too short.
Expected<mrpt::maps::CPointsMap::Ptr, std::string> cloudFrom(const ros1::PointCloud& message);
/// Whether the points come with their times, which MRPT's clouds cannot hold.
bool hasPointTimes(const ros1::PointCloud& message);

/// 8-bit, grey or BGR. Fails for an encoding that is not known or data that is too short.
Expected<cv::Mat, std::string> imageFrom(const ros1::Image& message);

/// `rectified`: of images that ROS' image_proc has undistorted. Fails for an unknown distortion.
Expected<mrpt::img::TCamera, std::string> calibrationFrom(const ros1::CameraInfo& message,
                                                          bool rectified);

/// Pose of the base, which is at T_child_base in the frame that the message is about. ROS'
/// covariances are of the position and of rotations about the fixed axes of the parent.
mrpt::poses::CPose3DPDFGaussian odometryFrom(const ros1::Odometry& message,
                                             const Pose3& T_child_base);

}  // namespace dynemo
