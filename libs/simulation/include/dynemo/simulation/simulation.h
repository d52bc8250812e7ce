// From a world to a dataset: everything the sensors record, and the truth.
#pragma once

#include <filesystem>
#include <functional>

#include "dynemo/simulation/world.h"

namespace dynemo::simulation {

struct SimulationCounts {
  std::size_t scans = 0, images = 0, points = 0;
};

/// Called now and then with the simulated time; false ends the recording early.
using KeepGoing = std::function<bool(double t_s)>;

/// Writes NAME.rawlog, NAME_Images/, NAME_entities.yaml, NAME_config.yaml, NAME_world.yaml,
/// NAME_gt_robot.tum, NAME_gt_entities.csv and NAME_meta.json into a folder, NAME being the world's
/// (share/doc/simulation.md). Memory does not grow with the duration; the bytes depend on the world
/// alone, not on `threads`. Throws ConfigError when the robot or an entity has no free way,
/// DataError when a file cannot be written.
SimulationCounts simulate(const World& world, const std::filesystem::path& folder, int threads,
                          const KeepGoing& keep_going);

}  // namespace dynemo::simulation
