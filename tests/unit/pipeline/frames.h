// Frames of a robot that drives along x, for tests of the pipeline.
#pragma once

#include "dynemo/core/noise.h"
#include "dynemo/pipeline/slam_pipeline.h"

namespace dynemo::test {

inline Stamp at(double seconds) { return Stamp::fromSeconds(1000.0 + seconds); }

/// A frame whose odometry says `T_odom_base`, without anything else.
inline SensorFrame frameAt(double seconds, const Pose3& T_odom_base) {
  SensorFrame frame;
  frame.stamp = at(seconds);
  frame.odometry = OdometryState{T_odom_base, std::nullopt};
  return frame;
}

/// Adds a detection of an object by another program.
inline void see(SensorFrame& frame, int id, const Pose3& T_base_entity, double sigma_m = 0.005) {
  ExternalDetection detection;
  detection.stamp = frame.stamp;
  detection.entity = {id};
  detection.class_name = "object";
  detection.T_base_entity = T_base_entity;
  detection.covariance = isotropicCovariance(sigma_m, 0.005);
  detection.odometry = frame.odometry;
  frame.detections.push_back(detection);
}

/// Parameters under which only detections of other programs are taken.
inline DynemoParams externalOnly() {
  DynemoParams params;
  params.perception.detectors = {"external"};
  return params;
}

inline void process(SlamPipeline& pipeline, SensorFrame frame) {
  FrameTiming timing;
  pipeline.process(std::move(frame), timing);
}

/// One box seen all the way by a robot whose odometry claims 4 % more than it drove: 0.2 m a frame
/// for as many frames.
inline void driveWithWrongScale(SlamPipeline& pipeline, int frames) {
  constexpr double kStep_m = 0.2, kScale = 1.04;
  const Pose3 T_map_box = Pose3::translation(10, 1, 0.3);
  for (int i = 0; i < frames; ++i) {
    const Pose3 T_map_base = Pose3::translation(i * kStep_m, 0, 0);
    SensorFrame frame = frameAt(0.2 * i, Pose3::translation(kScale * i * kStep_m, 0, 0));
    frame.index = static_cast<std::uint64_t>(i);
    see(frame, 7, T_map_base.inverse() * T_map_box);
    process(pipeline, std::move(frame));
  }
}

}  // namespace dynemo::test
