// Asks the map of a run from C++: query_example RUN_DIR prints where each object is at the end of
// the run, how likely it is still there an hour later, and what moved.
#include <cstdio>
#include <exception>

#include "dynemo/query/scene_query.h"

int main(int argc, char** argv) {
  using namespace dynemo;
  if (argc != 2) {
    std::fprintf(stderr, "usage: query_example RUN_DIR\n");
    return 2;
  }
  try {
    const Session session = loadRunSession(argv[1]);
    const SceneQuery query(session);
    const Stamp an_hour_later{query.end().ns + 3'600'000'000'000};
    for (const EntityId id : query.entities()) {
      const Whereabouts now = query.where(id, query.end());
      if (now.semantic_class != SemanticClass::kObject) continue;
      const Vector3& p = now.T_map_entity.t;
      std::printf("%s is at %.2f %.2f %.2f m (%.0f %%), in an hour with %.0f %%\n",
                  now.name.c_str(), p.x(), p.y(), p.z(), 100.0 * now.presence,
                  100.0 * query.where(id, an_hour_later).presence);
    }
    for (const Move& move : query.moved()) {
      std::printf("%s was moved by %.2f m between %s and %s\n", move.name.c_str(), move.distance(),
                  move.last_before.text().c_str(), move.first_after.text().c_str());
    }
  } catch (const std::exception& e) {
    std::fprintf(stderr, "query_example: %s\n", e.what());
    return 1;
  }
  return 0;
}
