#include "dynemo/evaluation/entity_error.h"

#include <utility>

#include "dynemo/core/noise.h"

namespace dynemo {
namespace {

using PlacementTable = std::map<EntityId, std::vector<Placement>>;

PlacementTable placementsOfObjects(const EntityTruths& truths, const PlacementParams& params) {
  PlacementTable table;
  for (const auto& [id, truth] : truths) {
    if (truth.semantic_class == SemanticClass::kObject) {
      table[id] = findPlacements(truth.poses, params);
    }
  }
  return table;
}

std::optional<double> nees(const EntityEstimate& estimate, const Pose3& T_world_map,
                           const Pose3& T_world_entity) {
  if (!estimate.covariance) return std::nullopt;
  const Vector6 e = local(T_world_map * estimate.T_map_entity, T_world_entity);
  return squaredMahalanobis(e, *estimate.covariance);
}

std::optional<EntityNodeError> nodeError(const EntityEstimate& estimate, const EntityTruths& truths,
                                         const Pose3& T_world_map, const PlacementTable& table) {
  const auto truth = truths.find(estimate.entity);
  if (truth == truths.end()) return std::nullopt;
  const auto T_world_entity = poseAt(truth->second.poses, estimate.stamp);
  if (!T_world_entity) return std::nullopt;
  EntityNodeError out;
  out.estimate = estimate;
  out.T_world_entity = *T_world_entity;
  out.T_world_entity_estimated = T_world_map * estimate.T_map_entity;
  out.first = poseError(*T_world_entity, T_world_map * estimate.T_map_entity_first);
  out.final = poseError(*T_world_entity, out.T_world_entity_estimated);
  if (const auto it = table.find(estimate.entity); it != table.end()) {
    out.placement = placementAt(it->second, estimate.stamp);
  }
  out.nees = nees(estimate, T_world_map, *T_world_entity);
  return out;
}

std::map<EntityId, EntitySummary> summarizeEntities(const std::vector<EntityNodeError>& nodes) {
  std::map<EntityId, std::vector<PoseError>> first, final;
  std::map<EntityId, EntitySummary> summaries;
  for (const EntityNodeError& node : nodes) {
    EntitySummary& summary = summaries[node.estimate.entity];
    summary.semantic_class = node.estimate.semantic_class;
    summary.name = node.estimate.name;
    first[node.estimate.entity].push_back(node.first);
    final[node.estimate.entity].push_back(node.final);
  }
  for (auto& [id, summary] : summaries) {
    summary.first = summarize(first[id]);
    summary.final = summarize(final[id]);
  }
  return summaries;
}

std::vector<PlacementError> summarizePlacements(const std::vector<EntityNodeError>& nodes) {
  std::map<std::pair<EntityId, std::size_t>, std::vector<const EntityNodeError*>> groups;
  for (const EntityNodeError& node : nodes) {
    if (node.placement) groups[{node.estimate.entity, *node.placement}].push_back(&node);
  }
  std::vector<PlacementError> list;
  for (const auto& [key, members] : groups) {
    const EntityNodeError* last = members.front();
    std::vector<PoseError> errors;
    for (const EntityNodeError* node : members) {
      errors.push_back(node->final);
      if (node->estimate.stamp >= last->estimate.stamp) last = node;
    }
    const PoseErrorStatistics all = summarize(errors);
    list.push_back({key.first,
                    key.second,
                    members.size(),
                    last->final,
                    {all.translation_m.median, all.rotation_rad.median}});
  }
  return list;
}

std::vector<PoseError> errorsOf(const EntityErrors& errors, SemanticClass semantic_class,
                                PoseError EntityNodeError::*which) {
  std::vector<PoseError> list;
  for (const EntityNodeError& node : errors.nodes) {
    if (node.estimate.semantic_class == semantic_class) list.push_back(node.*which);
  }
  return list;
}

}  // namespace

PoseError poseError(const Pose3& T_truth, const Pose3& T_estimate) {
  return {(T_estimate.t - T_truth.t).norm(), rotationAngle(T_truth.inverse() * T_estimate)};
}

PoseErrorStatistics summarize(const std::vector<PoseError>& errors) {
  std::vector<double> translations_m, rotations_rad;
  for (const PoseError& error : errors) {
    translations_m.push_back(error.translation_m);
    rotations_rad.push_back(error.rotation_rad);
  }
  return {summarize(translations_m), summarize(rotations_rad)};
}

EntityErrors evaluateEntities(const std::vector<EntityEstimate>& estimates,
                              const EntityTruths& truths, const Pose3& T_world_map,
                              const PlacementParams& params) {
  const PlacementTable table = placementsOfObjects(truths, params);
  EntityErrors errors;
  for (const EntityEstimate& estimate : estimates) {
    if (auto node = nodeError(estimate, truths, T_world_map, table)) {
      errors.nodes.push_back(std::move(*node));
    } else {
      ++errors.without_truth;
    }
  }
  errors.entities = summarizeEntities(errors.nodes);
  errors.placements = summarizePlacements(errors.nodes);
  return errors;
}

PoseErrorStatistics firstErrors(const EntityErrors& errors, SemanticClass semantic_class) {
  return summarize(errorsOf(errors, semantic_class, &EntityNodeError::first));
}

PoseErrorStatistics finalErrors(const EntityErrors& errors, SemanticClass semantic_class) {
  return summarize(errorsOf(errors, semantic_class, &EntityNodeError::final));
}

PoseErrorStatistics placementErrors(const EntityErrors& errors) {
  std::vector<PoseError> list;
  for (const PlacementError& placement : errors.placements) list.push_back(placement.last);
  return summarize(list);
}

NeesSummary neesSummary(const EntityErrors& errors, SemanticClass semantic_class) {
  NeesSummary summary;
  const double bound = chiSquaredQuantile(6, summary.probability);
  double sum = 0.0, inside = 0.0;
  for (const EntityNodeError& node : errors.nodes) {
    if (!node.nees || node.estimate.semantic_class != semantic_class) continue;
    ++summary.count;
    sum += *node.nees;
    inside += *node.nees <= bound ? 1.0 : 0.0;
  }
  if (summary.count == 0) return summary;
  summary.mean = sum / static_cast<double>(summary.count);
  summary.share_inside = inside / static_cast<double>(summary.count);
  return summary;
}

}  // namespace dynemo
