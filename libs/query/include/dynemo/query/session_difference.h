// What is different between two sessions of one place.
#pragma once

#include <string>
#include <vector>

#include "dynemo/query/scene_query.h"

namespace dynemo {

struct DifferenceParams {
  /// An object agrees with an alignment when its places in both sessions are this close.
  double max_distance_m = 0.15;
  double max_rotation_rad = 0.15;
  /// Fewer agreeing objects are no alignment: any two maps agree on one.
  int min_agreeing = 2;
  QueryParams query;
};
void fields(FieldVisitor& v, DifferenceParams& p);

enum class ObjectChange {
  kUnchanged,
  kMoved,
  kAppeared,     ///< in B only
  kDisappeared,  ///< in A only
};
const char* changeName(ObjectChange change);

/// One object of A or B. Poses are in the map of B; the one of a session that never saw the object
/// is empty.
struct ObjectDifference {
  EntityId entity{};
  std::string name;
  ObjectChange change = ObjectChange::kUnchanged;
  std::optional<Pose3> T_mapB_entityA, T_mapB_entityB;
  /// Disappeared: how likely its place of A is empty at the end of B. Appeared: how likely its
  /// place of B was empty at the end of A. By the scans that looked there; 0.5 when none did.
  double certainty = 1.0;
};

struct SessionDifference {
  /// Pose of A's map in B's map.
  Pose3 T_mapB_mapA;
  /// The objects that the alignment stands on, and their root mean square distance under it.
  std::vector<EntityId> agreeing;
  double rms_m = 0.0;
  /// Objects that both sessions saw.
  std::size_t common = 0;
  std::vector<ObjectDifference> objects;
};

/// Compares the ends of two sessions. The maps are aligned by the largest set of common objects
/// that agree on one rigid motion, each by some place where it stood in both; the error says why
/// there is none. Objects are the same by id.
Expected<SessionDifference, std::string> difference(const Session& a, const Session& b,
                                                    const DifferenceParams& params = {});

}  // namespace dynemo
