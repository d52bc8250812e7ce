#include "dynemo/query/scene_query.h"

#include <algorithm>
#include <cmath>

#include "agent_motion.h"
#include "dynemo/query/persistence.h"
#include "dynemo/query/sightlines.h"

namespace dynemo {
namespace {

/// The observations around a time; the later one is empty from the last observation on.
struct Around {
  const CNodeEntity* before = nullptr;
  const CNodeEntity* after = nullptr;
};

Around around(const EntityTrack& track, Stamp at) {
  Around found;
  for (const auto& node : track) {
    if (node->stamp <= at) {
      found.before = node.get();
    } else {
      found.after = node.get();
      break;
    }
  }
  return found;
}

Whereabouts identified(const EntityTrack& track, const Around& seen) {
  Whereabouts w;
  w.entity = track.front()->entity;
  w.name = entityTitle(*track.front());
  w.semantic_class = track.front()->semantic_class;
  if (seen.before) w.last_seen = seen.before->stamp;
  if (seen.after) w.next_seen = seen.after->stamp;
  return w;
}

/// The same looks with time running backwards from `to`.
std::vector<Look> reversed(std::vector<Look> looks, double span_s) {
  std::reverse(looks.begin(), looks.end());
  for (Look& look : looks) look.after_s = span_s - look.after_s;
  return looks;
}

/// Looks at the place an object left say when it left; looks at the place it came to say when it
/// came, which is `carried_s` later: a place that is occupied by the object is one that it has
/// reached.
std::vector<Look> merged(std::vector<Look> left, const std::vector<Look>& reached,
                         double carried_s) {
  for (const Look& look : reached) {
    // So early it cannot have come, whatever is seen there.
    if (look.after_s <= carried_s) continue;
    left.push_back({look.after_s - carried_s, 1.0 / look.likelihood_ratio});
  }
  std::stable_sort(left.begin(), left.end(),
                   [](const Look& a, const Look& b) { return a.after_s < b.after_s; });
  return left;
}

Stamp later(Stamp a, Stamp b) { return std::max(a, b); }

}  // namespace

SceneQuery::SceneQuery(const CSceneGraph& graph,
                       const std::map<NodeId, Matrix6>& entity_covariances,
                       const QueryParams& params)
    : graph_(graph), covariances_(entity_covariances), params_(params) {
  if (graph.keyframes().empty()) return;
  begin_ = graph.keyframes().front()->stamp;
  end_ = graph.keyframes().back()->stamp;
  for (const auto& [id, track] : graph.tracks()) end_ = later(end_, track.back()->stamp);
}

SceneQuery::SceneQuery(const Session& session, const QueryParams& params)
    : SceneQuery(session.graph, session.entity_covariances, params) {
  if (session.frames.empty()) return;
  begin_ = std::min(begin_, session.frames.front().stamp);
  end_ = later(end_, session.frames.back().stamp);
}

std::vector<EntityId> SceneQuery::entities() const {
  std::vector<EntityId> ids;
  for (const auto& [id, track] : graph_.tracks()) ids.push_back(id);
  return ids;
}

Expected<EntityId, std::string> SceneQuery::find(const std::string& id_or_name) const {
  std::vector<EntityId> by_name;
  std::string known;
  for (const auto& [id, track] : graph_.tracks()) {
    if (std::to_string(id.value) == id_or_name) return id;
    const CNodeEntity& node = *track.front();
    if (node.name == id_or_name || entityTitle(node) == id_or_name) by_name.push_back(id);
    known +=
        (known.empty() ? "" : ", ") + std::to_string(id.value) + " (" + entityTitle(node) + ")";
  }
  if (by_name.size() == 1) return by_name.front();
  if (by_name.empty()) {
    return make_unexpected("no entity '" + id_or_name +
                           "' in the map; known: " + (known.empty() ? "none" : known));
  }
  return make_unexpected("several entities are named '" + id_or_name + "': use the id");
}

Whereabouts SceneQuery::where(EntityId entity, Stamp at) const {
  const EntityTrack& track = trackOf(entity);
  return track.front()->semantic_class == SemanticClass::kAgent ? whereIsAgent(track, at)
                                                                : whereIsObject(track, at);
}

Whereabouts SceneQuery::whereIsAgent(const EntityTrack& track, Stamp at) const {
  const Around seen = around(track, at);
  Whereabouts w = identified(track, seen);
  const CNodeEntity& nearest = seen.before ? *seen.before : *seen.after;
  const double before_s = secondsBetween(nearest.stamp, at);
  double displacement_m2 = displacementVariance(before_s, params_);
  double heading_rad2 = headingVariance(before_s, params_);
  w.T_map_entity = nearest.T_map_entity();
  w.covariance = covarianceOf(nearest.id, covariances_);
  if (seen.before && seen.after && before_s > 0.0) {
    const double span_s = secondsBetween(seen.before->stamp, seen.after->stamp);
    w.T_map_entity =
        interpolate(seen.before->T_map_entity(), seen.after->T_map_entity(), before_s / span_s);
    // Both ends are known: their predictions are fused.
    const auto fused = [](double a, double b) { return a + b > 0.0 ? a * b / (a + b) : 0.0; };
    displacement_m2 = fused(displacement_m2, displacementVariance(span_s - before_s, params_));
    heading_rad2 = fused(heading_rad2, headingVariance(span_s - before_s, params_));
  }
  if (w.covariance) {
    w.covariance = withMotion(*w.covariance, w.T_map_entity.R, displacement_m2, heading_rad2);
  }
  w.presence = probabilityWithin(params_.agent_near_m, displacement_m2);
  return w;
}

SceneQuery::Looks SceneQuery::looksOf(const EntityTrack& track,
                                      const std::vector<Stay>& stays) const {
  Looks looks{extentOf(fragmentPoints(graph_, track)), params_};
  if (looks.extent)
    looks.params.missed_probability = missedProbability(graph_, stays, *looks.extent, params_);
  return looks;
}

std::vector<Look> SceneQuery::looksAtPlace(const Looks& looks, const Stay& place, Stamp from,
                                           Stamp to) const {
  if (!looks.extent) return {};
  return looksAt(graph_, place.T_map_entity, *looks.extent, from, to, looks.params);
}

Whereabouts SceneQuery::whereIsObject(const EntityTrack& track, Stamp at) const {
  const Around seen = around(track, at);
  Whereabouts w = identified(track, seen);
  const std::vector<Stay> stays = staysOf(track, covariances_, params_);
  const auto there = [&](const Stay& stay, double presence) {
    w.T_map_entity = stay.T_map_entity;
    w.covariance = stay.covariance;
    w.presence = presence;
    return w;
  };
  // The stay that goes on at the time, or the last one that began before.
  std::size_t k = 0;
  while (k + 1 < stays.size() && stays[k + 1].first_seen <= at) ++k;
  const Stay& stay = stays[k];
  if (at >= stay.first_seen && at <= stay.last_seen) return there(stay, 1.0);
  if (at > stay.last_seen && k + 1 < stays.size())
    return whereInBetween(track, stays, k, at, std::move(w));

  const Looks looks = looksOf(track, stays);
  DeparturePrior prior;
  prior.moves = static_cast<double>(stays.size() - 1);
  prior.residence_s = params_.object_residence_s;
  prior.observed_s = secondsBetween(stays.front().first_seen, stays.back().last_seen);
  if (at < stay.first_seen) {  // before the first observation, with time running backwards
    const Stamp start{std::min(begin_.ns, at.ns) - 1};
    const double span_s = secondsBetween(start, stay.first_seen);
    const auto seen_there = reversed(looksAtPlace(looks, stay, start, stay.first_seen), span_s);
    return there(stay, presenceProbability(prior, seen_there, secondsBetween(at, stay.first_seen)));
  }
  const Stamp beyond{std::max(end_.ns, at.ns) + 1};
  return there(stay, presenceProbability(prior, looksAtPlace(looks, stay, stay.last_seen, beyond),
                                         secondsBetween(stay.last_seen, at)));
}

/// What is believed of the time between two stays at different places.
struct SceneQuery::Journey {
  DeparturePrior prior;
  std::vector<Look> looks;
  double gap_s = 0.0, carried_s = 0.0;

  /// All in seconds after the object was last seen at the place it left.
  double notLeft(double after_s) const { return presenceProbability(prior, looks, after_s); }
  double arrived(double after_s) const {
    return after_s <= carried_s ? 0.0 : 1.0 - notLeft(after_s - carried_s);
  }
};

SceneQuery::Journey SceneQuery::journey(const EntityTrack& track, const std::vector<Stay>& stays,
                                        std::size_t k) const {
  const Stay &left = stays[k], &reached = stays[k + 1];
  const Looks looks = looksOf(track, stays);
  Journey j;
  j.gap_s = secondsBetween(left.last_seen, reached.first_seen);
  const double distance_m = (reached.T_map_entity.t - left.T_map_entity.t).norm();
  j.carried_s = std::min(distance_m / params_.object_carry_mps, 0.5 * j.gap_s);
  j.prior.gone_by_s = j.gap_s - j.carried_s;
  j.looks = merged(looksAtPlace(looks, left, left.last_seen, reached.first_seen),
                   looksAtPlace(looks, reached, left.last_seen, reached.first_seen), j.carried_s);
  return j;
}

Whereabouts SceneQuery::whereInBetween(const EntityTrack& track, const std::vector<Stay>& stays,
                                       std::size_t k, Stamp at, Whereabouts w) const {
  const Stay &left = stays[k], &reached = stays[k + 1];
  const double after_s = secondsBetween(left.last_seen, at);
  const double gap_s = secondsBetween(left.last_seen, reached.first_seen);
  if (gap_s <= params_.same_move_s) {  // moved while it was in view
    w.T_map_entity = interpolate(left.T_map_entity, reached.T_map_entity, after_s / gap_s);
    w.covariance = left.covariance;
    w.presence = 1.0;
    return w;
  }
  const Journey j = journey(track, stays, k);
  Candidate old{left.T_map_entity, left.covariance, j.notLeft(after_s)};
  Candidate other{reached.T_map_entity, reached.covariance, j.arrived(after_s)};
  if (other.presence > old.presence) std::swap(old, other);
  w.T_map_entity = old.T_map_entity;
  w.covariance = old.covariance;
  w.presence = old.presence;
  w.alternative = other;
  return w;
}

std::vector<Move> SceneQuery::movesOf(EntityId object) const {
  const EntityTrack& track = trackOf(object);
  std::vector<Move> moves;
  if (track.front()->semantic_class != SemanticClass::kObject) return moves;
  const std::vector<Stay> all = staysOf(track, covariances_, params_);
  const auto inView = [&](std::size_t i) {
    return secondsBetween(all[i - 1].last_seen, all[i].first_seen) <= params_.same_move_s;
  };
  for (std::size_t i = 1; i < all.size(); ++i) {
    const Stay &before = all[i - 1], &after = all[i];
    const Move move{object,
                    entityTitle(*track.front()),
                    before.T_map_entity,
                    after.T_map_entity,
                    before.last_seen,
                    after.first_seen};
    // A push in view is one move, not one per observation.
    if (i > 1 && before.observations == 1 && inView(i) && inView(i - 1)) {
      moves.back().T_map_after = move.T_map_after;
      moves.back().first_after = move.first_after;
    } else {
      moves.push_back(move);
    }
  }
  return moves;
}

double SceneQuery::probabilityDuring(const Move& move, Stamp from, Stamp to) const {
  if (from <= move.last_before && move.first_after <= to) return 1.0;
  const EntityTrack& track = trackOf(move.entity);
  const std::vector<Stay> stays = staysOf(track, covariances_, params_);
  std::size_t k = 0;
  while (k + 1 < stays.size() && stays[k].last_seen < move.last_before) ++k;
  const double gap_s = secondsBetween(move.last_before, move.first_after);
  const bool watched = k + 1 >= stays.size() || stays[k + 1].first_seen != move.first_after ||
                       gap_s <= params_.same_move_s;
  if (watched) return 1.0;  // on its way all the time
  const Journey j = journey(track, stays, k);
  const double from_s = secondsBetween(move.last_before, from);
  const double to_s = secondsBetween(move.last_before, to);
  // It left before the end of the window, and had not arrived at its beginning.
  return std::clamp(1.0 - j.notLeft(to_s) - j.arrived(from_s), 0.0, 1.0);
}

std::vector<Move> SceneQuery::moved(Stamp from, Stamp to) const {
  std::vector<Move> moves;
  for (const auto& [id, track] : graph_.tracks()) {
    for (Move& move : movesOf(id)) {
      if (move.last_before > to || move.first_after < from) continue;
      move.probability = probabilityDuring(move, from, to);
      moves.push_back(std::move(move));
    }
  }
  return moves;
}

std::vector<Whereabouts> SceneQuery::near(const Vector3& p_map, double radius_m, Stamp at) const {
  std::vector<Whereabouts> found;
  const auto distance = [&](const Whereabouts& w) { return (w.T_map_entity.t - p_map).norm(); };
  for (const EntityId id : entities()) {
    const Whereabouts w = where(id, at);
    if (distance(w) <= radius_m) found.push_back(w);
  }
  std::stable_sort(found.begin(), found.end(), [&](const Whereabouts& a, const Whereabouts& b) {
    return distance(a) < distance(b);
  });
  return found;
}

std::vector<Sighting> SceneQuery::track(EntityId entity) const {
  std::vector<Sighting> sightings;
  for (const auto& node : trackOf(entity)) {
    sightings.push_back(
        {node->stamp, node->T_map_entity(), covarianceOf(node->id, covariances_), node->moved});
  }
  return sightings;
}

std::vector<Stay> SceneQuery::stays(EntityId entity) const {
  return staysOf(trackOf(entity), covariances_, params_);
}

}  // namespace dynemo
