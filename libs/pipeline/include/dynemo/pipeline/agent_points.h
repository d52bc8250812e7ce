// Points of a scan on agents, which LiDAR odometry can do without.
#pragma once

#include <map>
#include <vector>

#include "dynemo/core/fields.h"
#include "dynemo/core/point_cloud.h"
#include "dynemo/ingest/sensor_frame.h"
#include "dynemo/perception/entity_observation.h"

namespace dynemo {

struct AgentPointsParams {
  bool left_out = false;
  double radius_m = 0.6;
  double max_age_s = 1.0;
  double growth_m_s = 0.3;
};
void fields(FieldVisitor& v, AgentPointsParams& p);

/// Where agents are: as seen in this frame, or for a while after they were last seen where constant
/// velocity takes them, as their motion model has it.
class AgentPoints {
 public:
  explicit AgentPoints(const AgentPointsParams& params) : params_(params) {}

  /// Indices of the scan's points, ascending, in upright cylinders around the agents. The frame's
  /// odometry places agents that are not among the observations; without it only these count.
  PointIndices of(const SensorFrame& frame,
                  const std::vector<EntityObservation>& observations) const;

  /// Remembers the agents seen from T_odom_base.
  void remember(Stamp stamp, const Pose3& T_odom_base,
                const std::vector<EntityObservation>& observations);

 private:
  struct Track {
    Stamp stamp;
    Vector3 p_odom;
    Vector3 velocity_m_s = Vector3::Zero();
  };
  struct Cylinder {
    Vector3 p_base;
    double radius_m;
  };
  std::vector<Cylinder> cylinders(const SensorFrame& frame,
                                  const std::vector<EntityObservation>& observations) const;

  AgentPointsParams params_;
  std::map<EntityId, Track> tracks_;
};

}  // namespace dynemo
