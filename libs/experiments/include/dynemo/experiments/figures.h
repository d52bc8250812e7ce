// Figures of the report, drawn by gnuplot as SVG.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "dynemo/experiments/run_result.h"

namespace dynemo::experiments {

struct Figure {
  std::string name, caption, svg;
};

/// Entity pose error over time of each setup, with and without timer; optimisation time against
/// graph nodes of each setup; a map from above of each dataset with the trajectories of all setups.
/// Data and scripts stay in `folder`. `worlds`: the world file of a dataset, where it is known.
/// Throws DataError when gnuplot fails.
std::vector<Figure> drawFigures(const std::vector<RunResult>& results,
                                const std::map<std::string, std::filesystem::path>& worlds,
                                const std::filesystem::path& folder);

}  // namespace dynemo::experiments
