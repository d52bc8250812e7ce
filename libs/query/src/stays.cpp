#include "dynemo/query/stays.h"

#include <limits>

namespace dynemo {
namespace {

double spread(const std::optional<Matrix6>& covariance) {
  return covariance ? covariance->topLeftCorner<3, 3>().trace()
                    : std::numeric_limits<double>::infinity();
}

bool isMove(const Pose3& T_before, const Pose3& T_after, const QueryParams& params) {
  const Pose3 step = T_before.inverse() * T_after;
  return step.t.norm() > params.min_move_m || rotationAngle(step) > params.min_move_rad;
}

/// Both stays as one, at the better known place.
Stay joined(const Stay& a, const Stay& b) {
  Stay stay = spread(b.covariance) <= spread(a.covariance) ? b : a;
  stay.first_seen = a.first_seen;
  stay.last_seen = b.last_seen;
  stay.observations = a.observations + b.observations;
  return stay;
}

}  // namespace

std::optional<Matrix6> covarianceOf(NodeId node, const std::map<NodeId, Matrix6>& covariances) {
  const auto it = covariances.find(node);
  return it == covariances.end() ? std::nullopt : std::optional(it->second);
}

std::vector<Stay> staysOf(const EntityTrack& track, const std::map<NodeId, Matrix6>& covariances,
                          const QueryParams& params) {
  std::vector<Stay> stays;
  for (const auto& node : track) {
    const Stay seen{node->T_map_entity(), covarianceOf(node->id, covariances), node->stamp,
                    node->stamp, 1};
    if (!stays.empty() && !node->moved) {
      stays.back() = joined(stays.back(), seen);
    } else {
      stays.push_back(seen);
    }
  }
  std::vector<Stay> confirmed;
  for (const Stay& stay : stays) {
    if (!confirmed.empty() && !isMove(confirmed.back().T_map_entity, stay.T_map_entity, params)) {
      confirmed.back() = joined(confirmed.back(), stay);
    } else {
      confirmed.push_back(stay);
    }
  }
  return confirmed;
}

}  // namespace dynemo
