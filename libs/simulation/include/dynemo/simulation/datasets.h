// The datasets of the paper (Table II), generated from a seed.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dynemo/simulation/world.h"

namespace dynemo::simulation {

/// kMini: a smaller place, coarser sensors, about a minute; for tests and first looks.
enum class Scale : std::uint8_t { kMini, kFull };

struct DatasetOptions {
  Scale scale = Scale::kFull;
  int seed = 1;
  /// Instead of the dataset's own length: shorter cuts it off, longer adds laps.
  std::optional<double> duration_s;
  /// Instead of the dataset's own: on for the hand-held ones.
  std::optional<bool> motion_distortion;
};

/// S-SASO, S-SAMO, …, R-MAMO, and two-storeys.
std::vector<std::string> datasetNames();

/// Throws ConfigError, listing the known names, when there is none of that name.
World makeDataset(const std::string& name, const DatasetOptions& options);

}  // namespace dynemo::simulation
