#pragma once

#include <string>
#include <vector>

#include "dynemo/core/point_cloud.h"
#include "dynemo/graph/node_entity.h"

namespace dynemo {

/// One entity seen in one frame (paper, Sec. III-A: an entity snapshot).
struct EntityObservation {
  EntityId entity{};
  SemanticClass semantic_class = SemanticClass::kObject;
  std::string name;
  /// When it was seen (the image's stamp).
  Stamp stamp;
  /// In the base frame of the SensorFrame's stamp: the robot's motion between that and `stamp` is accounted for.
  Pose3 T_base_entity;
  /// Of the right tangent of T_base_entity.
  Matrix6 covariance = Matrix6::Identity();
  /// RMS corner reprojection error [px]; 0 when not measured from corners.
  double reprojection_rms_px = 0.0;
  int tag_count = 0;
  /// Sensor that saw it.
  std::string sensor_label;
};

}  // namespace dynemo
