#pragma once

#include <map>
#include <optional>
#include <vector>

#include "dynemo/core/noise.h"
#include "dynemo/query/entity_extent.h"
#include "dynemo/query/query_params.h"

namespace dynemo {

/// A time during which an object was seen at one place.
struct Stay {
  /// Of its best known observation, with the covariance of its right tangent where computed.
  Pose3 T_map_entity;
  std::optional<Matrix6> covariance;
  Stamp first_seen, last_seen;
  int observations = 0;
};

/// The stays of an object in order of time: a new one begins where the motion model found it moved
/// and the final estimates agree that it did, by more than their covariances explain, and by more
/// than one sighting may be wrong by where there is only one.
std::vector<Stay> staysOf(const EntityTrack& track, const std::map<NodeId, Matrix6>& covariances,
                          const QueryParams& params);

/// Covariance of a node's tangent, where computed.
std::optional<Matrix6> covarianceOf(NodeId node, const std::map<NodeId, Matrix6>& covariances);

}  // namespace dynemo
