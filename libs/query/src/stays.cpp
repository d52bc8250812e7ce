#include "dynemo/query/stays.h"

#include <Eigen/Dense>
#include <algorithm>
#include <limits>

namespace dynemo {
namespace {

double spread(const std::optional<Matrix6>& covariance) {
  return covariance ? covariance->topLeftCorner<3, 3>().trace()
                    : std::numeric_limits<double>::infinity();
}

/// Squared Mahalanobis distance of two estimates; infinite where a covariance is unknown.
double mahalanobis2(const Stay& a, const Stay& b) {
  if (!a.covariance || !b.covariance) return std::numeric_limits<double>::infinity();
  Matrix6 R_a_b = Matrix6::Zero();  // the other's own axes in these
  R_a_b.topLeftCorner<3, 3>() = R_a_b.bottomRightCorner<3, 3>() =
      a.T_map_entity.R.transpose() * b.T_map_entity.R;
  const Matrix6 sum = *a.covariance + R_a_b * *b.covariance * R_a_b.transpose();
  const Vector6 step = local(a.T_map_entity, b.T_map_entity);
  return step.dot(sum.ldlt().solve(step));
}

double distance(const Stay& a, const Stay& b) {
  return (a.T_map_entity.t - b.T_map_entity.t).norm();
}

bool isMove(const Stay& before, const Stay& after, const QueryParams& params) {
  const Pose3 step = before.T_map_entity.inverse() * after.T_map_entity;
  return (step.t.norm() > params.min_move_m || rotationAngle(step) > params.min_move_rad) &&
         mahalanobis2(before, after) > params.noise_mahalanobis2;
}

/// Both stays as one, at the better known place.
Stay joined(const Stay& a, const Stay& b) {
  Stay stay = spread(b.covariance) <= spread(a.covariance) ? b : a;
  stay.first_seen = a.first_seen;
  stay.last_seen = b.last_seen;
  stay.observations = a.observations + b.observations;
  return stay;
}

/// Those that differ from the one before, each with what does not.
std::vector<Stay> joinedWhereUnmoved(const std::vector<Stay>& stays, const QueryParams& params) {
  std::vector<Stay> list;
  for (const Stay& stay : stays) {
    if (!list.empty() && !isMove(list.back(), stay, params)) {
      list.back() = joined(list.back(), stay);
    } else {
      list.push_back(stay);
    }
  }
  return list;
}

/// Whether the sightings of stay `i` were wrong: not far from where the object was seen more often
/// before and after, or a single one in the beginning or the end.
bool isSlip(const std::vector<Stay>& stays, std::size_t i, const QueryParams& params) {
  const Stay& stay = stays[i];
  const Stay* before = i > 0 ? &stays[i - 1] : nullptr;
  const Stay* after = i + 1 < stays.size() ? &stays[i + 1] : nullptr;
  const auto near = [&](const Stay* other) {
    return other && distance(*other, stay) <= params.max_slip_m;
  };
  if (before && after)
    return stay.observations <= std::min(before->observations, after->observations) &&
           near(before) && !isMove(*before, *after, params);
  const Stay* other = before ? before : after;
  return stay.observations == 1 && near(other) && other->observations > 1;
}

/// The object was seen, but not moved, where a sighting was wrong.
std::vector<Stay> withoutSlips(const std::vector<Stay>& stays, const QueryParams& params) {
  std::vector<Stay> list;
  for (std::size_t i = 0; i < stays.size(); ++i) {
    if (!isSlip(stays, i, params)) {
      list.push_back(stays[i]);
      continue;
    }
    Stay seen = stays[i];
    const Stay& place = i > 0 ? stays[i - 1] : stays[i + 1];
    seen.T_map_entity = place.T_map_entity;
    seen.covariance = place.covariance;
    list.push_back(seen);
  }
  return joinedWhereUnmoved(list, params);
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
  return withoutSlips(joinedWhereUnmoved(stays, params), params);
}

}  // namespace dynemo
