// The tables of the study: means over seeds beside the paper's figures.
#pragma once

#include <string>
#include <vector>

#include "dynemo/experiments/mean_interval.h"
#include "dynemo/experiments/paper_tables.h"
#include "dynemo/experiments/run_result.h"

namespace dynemo::experiments {

/// All seeds of one dataset, odometry and setup.
struct Cell {
  std::string dataset, odometry, setup;
  MeanInterval ate_rmse_cm, ate_std_cm, odometry_ate_cm, optimization_ms, optimization_cpu_ms;
  MeanInterval loop_closures;                    ///< count 0 when loops are not closed
  MeanInterval entity_first_cm, entity_last_cm;  ///< of the objects
};

/// In the order in which dataset, odometry and setup first appear.
std::vector<Cell> cellsOf(const std::vector<RunResult>& results);
const Cell* findCell(const std::vector<Cell>& cells, const std::string& dataset,
                     const std::string& odometry, const std::string& setup);

/// One row per run.
std::string runsCsv(const std::vector<RunResult>& results);
/// One row per cell, with the paper's figures where it has them.
std::string tablesCsv(const std::vector<Cell>& cells, const PaperTables& paper);
/// One row per entity and run: error at the first registration and at the end.
std::string entitiesCsv(const std::vector<RunResult>& results);

}  // namespace dynemo::experiments
