#include "dynemo/perception/tag_pose.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "corner_refinement.h"
#include "planar_pose.h"

namespace dynemo {
namespace {

/// Tags that give starting poses; the others only take part in the refinement.
constexpr std::size_t kMaxStartTags = 3;
/// Minima closer than this are the same [rad].
constexpr double kSameMinimum_rad = 0.02;

double cross(const Vector2& a, const Vector2& b) { return a.x() * b.y() - a.y() * b.x(); }

double area_px2(const TagCornerObservation& tag) {
  const auto& p = tag.corners_px;
  return 0.5 * std::abs(cross(p[2] - p[0], p[3] - p[1]));
}

double longestEdge_px(const TagCornerObservation& tag) {
  double longest = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    longest = std::max(longest, (tag.corners_px[(i + 1) % 4] - tag.corners_px[i]).norm());
  }
  return longest;
}

/// All turns of the outline have the same sign.
bool isConvex(const TagCornerObservation& tag) {
  const auto& p = tag.corners_px;
  int positive = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const double turn = cross(p[(i + 1) % 4] - p[i], p[(i + 2) % 4] - p[(i + 1) % 4]);
    if (!std::isfinite(turn) || turn == 0.0) return false;
    positive += turn > 0.0 ? 1 : 0;
  }
  return positive == 0 || positive == 4;
}

const TagModel* findTag(const EntityModel& model, int tag_id) {
  const auto it = std::find_if(model.tags.begin(), model.tags.end(),
                               [&](const TagModel& tag) { return tag.tag_id == tag_id; });
  return it == model.tags.end() ? nullptr : &*it;
}

/// The usable tags of the entity, the largest in the image first.
std::vector<TagMeasurement> usableTags(const EntityModel& model,
                                       std::span<const TagCornerObservation> tags,
                                       const TagPoseParams& params) {
  std::vector<TagMeasurement> usable;
  std::set<int> seen;
  for (const TagCornerObservation& tag : tags) {
    const TagModel* tag_model = findTag(model, tag.tag_id);
    if (!tag_model || !isConvex(tag) || !seen.insert(tag.tag_id).second) continue;
    const double edge = effectiveEdge_px(tag);
    if (!(edge >= params.min_edge_px)) continue;
    const double sigma =
        std::max(params.corner_sigma_floor_px,
                 params.corner_sigma_base_px + params.corner_sigma_slope_px2 / edge);
    usable.push_back({tag.tag_id, tag_model->corners(), tag, tag_model, sigma});
  }
  std::stable_sort(usable.begin(), usable.end(), [](const auto& a, const auto& b) {
    return area_px2(a.observation) > area_px2(b.observation);
  });
  return usable;
}

std::vector<Pose3> startingPoses(const CameraModel& camera, std::span<const TagMeasurement> tags) {
  std::vector<Pose3> starts;
  for (const TagMeasurement& tag : tags.first(std::min(kMaxStartTags, tags.size()))) {
    for (const Pose3& T_camera_tag : planarPoses(camera, tag.observation, tag.model->size_m)) {
      starts.push_back(T_camera_tag * tag.model->T_entity_tag.inverse());
    }
  }
  return starts;
}

/// A minimum and the tags that agree with it.
struct Consensus {
  PoseMinimum minimum;
  std::vector<TagMeasurement> agreeing;
};

std::optional<Consensus> consensusFrom(const Pose3& start, const CameraModel& camera,
                                       std::span<const TagMeasurement> tags,
                                       const TagPoseParams& params) {
  Consensus result;
  Pose3 T_camera_entity = start;
  if (tags.size() > 1) {  // find the majority's pose first, so that one wrong tag cannot bend it
    const auto robust = refine(start, camera, tags, CornerLoss::kCauchy, params.max_iterations);
    if (!robust) return std::nullopt;
    T_camera_entity = robust->T_camera_entity;
    for (const TagMeasurement& tag : tags) {
      const auto rms = reprojectionRms_px(T_camera_entity, camera, tag);
      if (rms && *rms <= params.max_reprojection_px) result.agreeing.push_back(tag);
    }
  } else {
    result.agreeing.assign(tags.begin(), tags.end());
  }
  if (result.agreeing.empty()) return std::nullopt;
  const auto minimum =
      refine(T_camera_entity, camera, result.agreeing, CornerLoss::kSquared, params.max_iterations);
  if (!minimum) return std::nullopt;
  result.minimum = *minimum;
  return result;
}

bool better(const Consensus& a, const Consensus& b) {
  if (a.agreeing.size() != b.agreeing.size()) return a.agreeing.size() > b.agreeing.size();
  return a.minimum.chi2 < b.minimum.chi2;
}

/// The tags that agree must outnumber those that do not.
bool isMajority(std::size_t agreeing, std::size_t all) { return 2 * agreeing > all; }

EntityPoseSolution summarise(const std::vector<Consensus>& ordered,
                             std::span<const TagMeasurement> tags) {
  EntityPoseSolution solution;
  const Consensus& best = ordered.front();
  solution.best = best.minimum;
  for (const TagMeasurement& tag : best.agreeing) solution.used_tags.push_back(tag.tag_id);
  std::sort(solution.used_tags.begin(), solution.used_tags.end());
  for (const TagMeasurement& tag : tags) {
    if (!std::binary_search(solution.used_tags.begin(), solution.used_tags.end(), tag.tag_id)) {
      solution.rejected_tags.push_back(tag.tag_id);
    }
  }
  std::sort(solution.rejected_tags.begin(), solution.rejected_tags.end());
  solution.degrees_of_freedom = 8 * static_cast<int>(best.agreeing.size()) - 6;
  for (const Consensus& other : ordered) {
    if (other.agreeing.size() < best.agreeing.size()) break;
    const Vector6 apart = local(best.minimum.T_camera_entity, other.minimum.T_camera_entity);
    if (apart.tail<3>().norm() < kSameMinimum_rad) continue;
    solution.second = other.minimum;
    break;
  }
  return solution;
}

}  // namespace

double effectiveEdge_px(const TagCornerObservation& tag) {
  const double longest = longestEdge_px(tag);
  return longest > 0.0 ? area_px2(tag) / longest : 0.0;
}

const char* text(TagPoseFailure failure) {
  switch (failure) {
    case TagPoseFailure::kNoUsableTag:
      return "no usable tag";
    case TagPoseFailure::kNotConverged:
      return "pose solver did not converge";
    case TagPoseFailure::kReprojection:
      return "reprojection error too large";
    case TagPoseFailure::kInconsistentTags:
      return "tags of one entity contradict each other";
    case TagPoseFailure::kAmbiguous:
      return "ambiguous pose";
  }
  return "";
}

Expected<EntityPoseSolution, TagPoseFailure> solveEntityPose(
    const EntityModel& model, const CameraModel& camera, std::span<const TagCornerObservation> tags,
    const TagPoseParams& params) {
  if (!camera.valid()) return make_unexpected(TagPoseFailure::kNoUsableTag);
  const std::vector<TagMeasurement> usable = usableTags(model, tags, params);
  if (usable.empty()) return make_unexpected(TagPoseFailure::kNoUsableTag);

  std::vector<Consensus> found;
  for (const Pose3& start : startingPoses(camera, usable)) {
    auto consensus = consensusFrom(start, camera, usable, params);
    if (consensus) found.push_back(std::move(*consensus));
  }
  if (found.empty()) {
    return make_unexpected(usable.size() > 1 ? TagPoseFailure::kInconsistentTags
                                             : TagPoseFailure::kNotConverged);
  }
  std::stable_sort(found.begin(), found.end(), better);
  const Consensus& best = found.front();
  if (!isMajority(best.agreeing.size(), usable.size())) {
    return make_unexpected(TagPoseFailure::kInconsistentTags);
  }
  if (!(best.minimum.reprojection_rms_px <= params.max_reprojection_px)) {
    return make_unexpected(TagPoseFailure::kReprojection);
  }
  return summarise(found, usable);
}

}  // namespace dynemo
