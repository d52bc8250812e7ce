// The places of the datasets, without entities.
#pragma once

#include "dynemo/simulation/datasets.h"
#include "dynemo/simulation/world.h"
#include "random.h"

namespace dynemo::simulation {

/// A place and one lap through it.
struct FloorPlan {
  std::vector<Storey> storeys;
  std::vector<RoutePoint> lap;
  double robot_radius_m = 0.25;
};

/// Rooms full of furniture on both sides of a corridor: three and three, at mini scale two on one
/// side.
FloorPlan furnishedRooms(Scale scale, Random& random);
/// Three large bare rooms in a row, at mini scale two.
FloorPlan largeRooms(Scale scale);
/// One large bare room.
FloorPlan oneRoom(Scale scale);
/// A hall with furniture along its walls.
FloorPlan hall(Random& random);
/// Two storeys joined by stairs.
FloorPlan twoStoreys(Random& random);

}  // namespace dynemo::simulation
