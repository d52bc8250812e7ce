// Questions to a map: where things are and were, what moved, what is near.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "dynemo/core/error.h"
#include "dynemo/graph/session.h"
#include "dynemo/query/entity_extent.h"
#include "dynemo/query/persistence.h"
#include "dynemo/query/query_params.h"
#include "dynemo/query/stays.h"

namespace dynemo {

/// Another place at which an object may be.
struct Candidate {
  Pose3 T_map_entity;
  std::optional<Matrix6> covariance;
  double presence = 0.0;
};

/// An entity as the map believes it at one time.
struct Whereabouts {
  EntityId entity{};
  std::string name;
  SemanticClass semantic_class = SemanticClass::kObject;
  /// Objects: the place that is most probable at the time. Agents: where last seen, or between two
  /// observations on the straight line between them.
  Pose3 T_map_entity;
  /// Of the right tangent of T_map_entity, given that it is there: as estimated, for agents with
  /// the motion since. Empty when the run computed none.
  std::optional<Matrix6> covariance;
  /// The observations around the time; the one at the time itself counts as the last.
  std::optional<Stamp> last_seen, next_seen;
  /// How likely it is there at the time. Objects: that it has not left (or not yet come); agents:
  /// that it is within QueryParams::agent_near_m.
  double presence = 0.0;
  /// Objects that were seen at one place before the time and at another one after it: that of the
  /// two which is less probable. What is left of 1 is that the object is on its way.
  std::optional<Candidate> alternative{};

  /// How likely an object is on its way from one place to another.
  double carried() const { return alternative ? 1.0 - presence - alternative->presence : 0.0; }
};

/// An object that was displaced.
struct Move {
  EntityId entity{};
  std::string name;
  Pose3 T_map_before, T_map_after;
  /// It happened between these two observations.
  Stamp last_before, first_after;
  /// How likely the object was on its way at some time of those that were asked for. It did move,
  /// so that over all of last_before to first_after this is 1.
  double probability = 1.0;
  double distance() const { return (T_map_after.t - T_map_before.t).norm(); }
};

/// One observation of an entity.
struct Sighting {
  Stamp stamp;
  Pose3 T_map_entity;
  std::optional<Matrix6> covariance;
  bool moved = false;
};

/// Does not own what it asks: the graph, or the session, must outlive it.
class SceneQuery {
 public:
  explicit SceneQuery(const Session& session, const QueryParams& params = {});
  SceneQuery(const CSceneGraph& graph, const std::map<NodeId, Matrix6>& entity_covariances,
             const QueryParams& params = {});
  explicit SceneQuery(Session&&, const QueryParams& = {}) = delete;

  /// First and last time the map knows of.
  Stamp begin() const { return begin_; }
  Stamp end() const { return end_; }

  std::vector<EntityId> entities() const;
  /// By id ("3") or by name ("box 3", whole and case-sensitive); the error says why there is not
  /// exactly one.
  Expected<EntityId, std::string> find(const std::string& id_or_name) const;

  /// Where an entity is at a time, before its first observation too. Throws std::out_of_range for
  /// an unknown entity.
  Whereabouts where(EntityId entity, Stamp at) const;
  /// The moves of objects whose window of time meets [from, to], by entity and time, each with how
  /// likely it happened then.
  std::vector<Move> moved(Stamp from, Stamp to) const;
  std::vector<Move> moved() const { return moved(begin_, end_); }
  /// The moves of one object in order of time; none of an agent, which moves by itself. Throws
  /// std::out_of_range for an unknown entity.
  std::vector<Move> movesOf(EntityId object) const;
  /// Entities within a distance of a point in the map at a time, nearest first.
  std::vector<Whereabouts> near(const Vector3& p_map, double radius_m, Stamp at) const;
  /// All observations of an entity in order of time. Throws std::out_of_range for an unknown
  /// entity.
  std::vector<Sighting> track(EntityId entity) const;
  /// Places of an object in order of time.
  std::vector<Stay> stays(EntityId entity) const;

 private:
  const EntityTrack& trackOf(EntityId entity) const { return graph_.tracks().at(entity); }
  Whereabouts whereIsObject(const EntityTrack& track, Stamp at) const;
  Whereabouts whereIsAgent(const EntityTrack& track, Stamp at) const;
  Whereabouts whereInBetween(const EntityTrack& track, const std::vector<Stay>& stays,
                             std::size_t k, Stamp at, Whereabouts w) const;
  double probabilityDuring(const Move& move, Stamp from, Stamp to) const;

  /// What scans can say of one object.
  struct Looks {
    std::optional<Extent> extent;
    QueryParams params;  ///< with how often this object is missed
  };
  Looks looksOf(const EntityTrack& track, const std::vector<Stay>& stays) const;
  std::vector<Look> looksAtPlace(const Looks& looks, const Stay& place, Stamp from, Stamp to) const;
  struct Journey;
  Journey journey(const EntityTrack& track, const std::vector<Stay>& stays, std::size_t k) const;

  const CSceneGraph& graph_;
  const std::map<NodeId, Matrix6>& covariances_;
  QueryParams params_;
  Stamp begin_, end_;
};

}  // namespace dynemo
