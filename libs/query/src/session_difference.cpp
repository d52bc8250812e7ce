#include "dynemo/query/session_difference.h"

#include <Eigen/Dense>
#include <algorithm>

#include "dynemo/query/sightlines.h"

namespace dynemo {
namespace {

/// An object of both sessions: a place where A saw it and one where B did.
struct Pair {
  EntityId entity{};
  Pose3 T_a_entity, T_b_entity;
};

bool isObject(const EntityTrack& track) {
  return track.front()->semantic_class == SemanticClass::kObject;
}

/// By object all pairs of its places, since it may have moved and come back in either session.
using CommonObjects = std::vector<std::vector<Pair>>;

CommonObjects commonObjects(const CSceneGraph& a, const SceneQuery& query_a, const CSceneGraph& b,
                            const SceneQuery& query_b) {
  CommonObjects objects;
  for (const auto& [id, track] : a.tracks()) {
    const auto in_b = b.tracks().find(id);
    if (in_b == b.tracks().end() || !isObject(track) || !isObject(in_b->second)) continue;
    std::vector<Pair>& pairs = objects.emplace_back();
    for (const Stay& place_a : query_a.stays(id))
      for (const Stay& place_b : query_b.stays(id))
        pairs.push_back({id, place_a.T_map_entity, place_b.T_map_entity});
  }
  return objects;
}

double distance(const Pose3& T_b_a, const Pair& pair) {
  return (T_b_a * pair.T_a_entity.t - pair.T_b_entity.t).norm();
}

bool agrees(const Pose3& T_b_a, const Pair& pair, const DifferenceParams& params) {
  const Pose3 T_b_entityA = T_b_a * pair.T_a_entity;
  return (T_b_entityA.t - pair.T_b_entity.t).norm() <= params.max_distance_m &&
         rotationAngle(T_b_entityA.inverse() * pair.T_b_entity) <= params.max_rotation_rad;
}

/// Of each object that agrees its nearest pair.
std::vector<Pair> agreeing(const Pose3& T_b_a, const CommonObjects& objects,
                           const DifferenceParams& params) {
  std::vector<Pair> list;
  for (const std::vector<Pair>& pairs : objects) {
    const Pair* nearest = nullptr;
    for (const Pair& pair : pairs) {
      if (!agrees(T_b_a, pair, params)) continue;
      if (!nearest || distance(T_b_a, pair) < distance(T_b_a, *nearest)) nearest = &pair;
    }
    if (nearest) list.push_back(*nearest);
  }
  return list;
}

/// The rigid motion that brings the objects' positions and axes together best. Each object counts
/// as its position and three points on its axes at the distance where its rotation error weighs
/// like its position error.
Pose3 bestMotion(const std::vector<Pair>& pairs, const DifferenceParams& params) {
  const double arm_m = params.max_distance_m / params.max_rotation_rad;
  Eigen::Matrix3Xd from(3, 4 * pairs.size()), to(3, 4 * pairs.size());
  Eigen::Index column = 0;
  for (const Pair& pair : pairs) {
    for (const Vector3& p :
         {Vector3(0, 0, 0), Vector3(arm_m, 0, 0), Vector3(0, arm_m, 0), Vector3(0, 0, arm_m)}) {
      from.col(column) = pair.T_a_entity * p;
      to.col(column++) = pair.T_b_entity * p;
    }
  }
  const Eigen::Matrix4d T = Eigen::umeyama(from, to, false);
  return Pose3(T.topLeftCorner<3, 3>(), T.topRightCorner<3, 1>()).normalized();
}

double rmsDistance(const Pose3& T_b_a, const std::vector<Pair>& pairs) {
  double sum = 0.0;
  for (const Pair& p : pairs) sum += distance(T_b_a, p) * distance(T_b_a, p);
  return pairs.empty() ? 0.0 : std::sqrt(sum / static_cast<double>(pairs.size()));
}

struct Alignment {
  Pose3 T_b_a;
  std::vector<Pair> agreeing;
  double rms_m = 0.0;
};

/// Refines until the set of agreeing objects stays the same.
Alignment refined(Pose3 T_b_a, const CommonObjects& objects, const DifferenceParams& params) {
  constexpr int kMostRounds = 20;
  std::vector<Pair> set = agreeing(T_b_a, objects, params);
  for (int round = 0; round < kMostRounds && !set.empty(); ++round) {
    T_b_a = bestMotion(set, params);
    std::vector<Pair> next = agreeing(T_b_a, objects, params);
    const bool same = next.size() == set.size();
    set = std::move(next);
    if (same) break;
  }
  return {T_b_a, set, rmsDistance(T_b_a, set)};
}

/// Hypotheses from every pair of places alone and, while they are not too many, from every two: all
/// of them, so that nothing is left to chance. The best is the one on which most objects agree, and
/// all of those make it up.
Alignment align(const CommonObjects& objects, const DifferenceParams& params) {
  std::vector<Pair> pairs;
  for (const auto& of_one : objects) pairs.insert(pairs.end(), of_one.begin(), of_one.end());
  Alignment best;
  const auto consider = [&](const std::vector<Pair>& sample) {
    const Alignment found = refined(bestMotion(sample, params), objects, params);
    if (found.agreeing.size() > best.agreeing.size() ||
        (found.agreeing.size() == best.agreeing.size() && found.rms_m < best.rms_m)) {
      best = found;
    }
  };
  constexpr std::size_t kMostForPairs = 100;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    consider({pairs[i]});
    if (pairs.size() > kMostForPairs) continue;
    for (std::size_t j = i + 1; j < pairs.size(); ++j)
      if (pairs[j].entity != pairs[i].entity) consider({pairs[i], pairs[j]});
  }
  return best;
}

/// How likely a place is empty by all scans of a session that looked at it.
double emptiness(const CSceneGraph& graph, const SceneQuery& query, const Pose3& T_map_entity,
                 const std::optional<Extent>& extent, const QueryParams& params) {
  if (!extent) return 0.5;
  const Stamp from{query.begin().ns - 1}, to{query.end().ns + 1};
  const auto looks = looksAt(graph, T_map_entity, *extent, from, to, params);
  double odds_there = 1.0;
  for (const Look& look : looks) odds_there *= look.likelihood_ratio;
  return 1.0 / (1.0 + odds_there);
}

struct Side {
  const CSceneGraph& graph;
  const SceneQuery& query;
};

ObjectDifference compared(EntityId id, const Side& a, const Side& b, const Pose3& T_b_a,
                          const DifferenceParams& params) {
  const auto in_a = a.graph.tracks().find(id), in_b = b.graph.tracks().find(id);
  const bool has_a = in_a != a.graph.tracks().end(), has_b = in_b != b.graph.tracks().end();
  const EntityTrack& track = has_b ? in_b->second : in_a->second;
  ObjectDifference d;
  d.entity = id;
  d.name = entityTitle(*track.front());
  if (has_a) d.T_mapB_entityA = T_b_a * a.query.stays(id).back().T_map_entity;
  if (has_b) d.T_mapB_entityB = b.query.stays(id).back().T_map_entity;
  if (has_a && has_b) {
    const Pair pair{id, *d.T_mapB_entityA, *d.T_mapB_entityB};
    d.change = agrees(Pose3(), pair, params) ? ObjectChange::kUnchanged : ObjectChange::kMoved;
  } else if (has_a) {
    d.change = ObjectChange::kDisappeared;
    const auto extent = extentOf(fragmentPoints(a.graph, track));
    d.certainty = emptiness(b.graph, b.query, *d.T_mapB_entityA, extent, params.query);
  } else {
    d.change = ObjectChange::kAppeared;
    const auto extent = extentOf(fragmentPoints(b.graph, track));
    d.certainty =
        emptiness(a.graph, a.query, T_b_a.inverse() * *d.T_mapB_entityB, extent, params.query);
  }
  return d;
}

std::vector<EntityId> allObjects(const CSceneGraph& a, const CSceneGraph& b) {
  std::vector<EntityId> ids;
  for (const CSceneGraph* graph : {&a, &b}) {
    for (const auto& [id, track] : graph->tracks()) {
      if (isObject(track)) ids.push_back(id);
    }
  }
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  return ids;
}

}  // namespace

const char* changeName(ObjectChange change) {
  constexpr const char* kNames[] = {"unchanged", "moved", "appeared", "disappeared"};
  return kNames[static_cast<int>(change)];
}

Expected<SessionDifference, std::string> difference(const Session& a, const Session& b,
                                                    const DifferenceParams& params) {
  const SceneQuery query_a(a, params.query), query_b(b, params.query);
  const CommonObjects common = commonObjects(a.graph, query_a, b.graph, query_b);
  const Alignment alignment = align(common, params);
  if (alignment.agreeing.size() < static_cast<std::size_t>(params.min_agreeing)) {
    return make_unexpected("the sessions cannot be aligned: of " + std::to_string(common.size()) +
                           " objects in common, " + std::to_string(alignment.agreeing.size()) +
                           " agree on one motion; it takes " + std::to_string(params.min_agreeing));
  }
  SessionDifference result;
  result.T_mapB_mapA = alignment.T_b_a;
  result.rms_m = alignment.rms_m;
  result.common = common.size();
  for (const Pair& pair : alignment.agreeing) result.agreeing.push_back(pair.entity);
  const Side side_a{a.graph, query_a}, side_b{b.graph, query_b};
  for (const EntityId id : allObjects(a.graph, b.graph)) {
    result.objects.push_back(compared(id, side_a, side_b, alignment.T_b_a, params));
  }
  return result;
}

}  // namespace dynemo
