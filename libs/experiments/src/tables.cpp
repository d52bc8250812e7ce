#include "dynemo/experiments/tables.h"

#include <algorithm>

#include "dynemo/core/output_file.h"

namespace dynemo::experiments {
namespace {

constexpr double kCentimetres = 100.0;

template <class Value>
MeanInterval over(const std::vector<const RunResult*>& runs, Value value) {
  std::vector<double> values;
  for (const RunResult* run : runs) values.push_back(value(*run));
  return meanInterval(values);
}

Cell cellOf(const std::vector<const RunResult*>& runs) {
  const RunKey& key = runs.front()->key;
  Cell cell{key.dataset, key.odometry, key.setup, {}, {}, {}, {}, {}, {}, {}, {}};
  cell.ate_rmse_cm = over(runs, [](const RunResult& r) { return kCentimetres * r.ate_rmse_m; });
  cell.ate_std_cm = over(runs, [](const RunResult& r) { return kCentimetres * r.ate_std_m; });
  cell.odometry_ate_cm =
      over(runs, [](const RunResult& r) { return kCentimetres * r.odometry_ate_m; });
  cell.optimization_ms = over(runs, [](const RunResult& r) { return r.optimization_ms; });
  cell.optimization_cpu_ms = over(runs, [](const RunResult& r) { return r.optimization_cpu_ms; });
  std::vector<double> closures, first, last;
  for (const RunResult* run : runs) {
    if (run->loop_closures) closures.push_back(*run->loop_closures);
    for (const EntityResult& e : run->entities) {
      if (e.semantic_class != "object") continue;
      first.push_back(kCentimetres * e.first_m);
      last.push_back(kCentimetres * e.last_m);
    }
  }
  cell.loop_closures = meanInterval(closures);
  cell.entity_first_cm = meanInterval(first);
  cell.entity_last_cm = meanInterval(last);
  return cell;
}

std::string csv(const MeanInterval& m) {
  if (m.count == 0) return ",";
  return exactNumber(m.mean) + "," + exactNumber(m.half_width);
}

}  // namespace

std::vector<Cell> cellsOf(const std::vector<RunResult>& results) {
  std::vector<std::vector<const RunResult*>> groups;
  for (const RunResult& result : results) {
    const auto same = [&](const std::vector<const RunResult*>& group) {
      const RunKey& key = group.front()->key;
      return key.dataset == result.key.dataset && key.odometry == result.key.odometry &&
             key.setup == result.key.setup;
    };
    const auto it = std::find_if(groups.begin(), groups.end(), same);
    if (it == groups.end())
      groups.push_back({&result});
    else
      it->push_back(&result);
  }
  std::vector<Cell> cells;
  for (const auto& group : groups) cells.push_back(cellOf(group));
  return cells;
}

const Cell* findCell(const std::vector<Cell>& cells, const std::string& dataset,
                     const std::string& odometry, const std::string& setup) {
  const auto it = std::find_if(cells.begin(), cells.end(), [&](const Cell& c) {
    return c.dataset == dataset && c.odometry == odometry && c.setup == setup;
  });
  return it == cells.end() ? nullptr : &*it;
}

std::string runsCsv(const std::vector<RunResult>& results) {
  std::string text =
      "dataset,seed,odometry,setup,ate_rmse_m,ate_std_m,odometry_ate_m,loop_closures,optimizations,"
      "optimization_ms,optimization_cpu_ms\n";
  for (const RunResult& r : results) {
    text += r.key.dataset + "," + std::to_string(r.key.seed) + "," + r.key.odometry + "," +
            r.key.setup + "," + exactNumber(r.ate_rmse_m) + "," + exactNumber(r.ate_std_m) + "," +
            exactNumber(r.odometry_ate_m) + "," +
            (r.loop_closures ? std::to_string(*r.loop_closures) : "") + "," +
            std::to_string(r.optimizations) + "," + exactNumber(r.optimization_ms) + "," +
            exactNumber(r.optimization_cpu_ms) + "\n";
  }
  return text;
}

std::string tablesCsv(const std::vector<Cell>& cells, const PaperTables& paper) {
  std::string text =
      "dataset,odometry,setup,seeds,ate_rmse_cm,ate_rmse_ci95_cm,ate_std_cm,ate_std_ci95_cm,"
      "odometry_ate_cm,odometry_ate_ci95_cm,loop_closures,loop_closures_ci95,optimization_ms,"
      "optimization_ci95_ms,optimization_cpu_ms,optimization_cpu_ci95_ms,object_first_cm,object_"
      "first_ci95_cm,object_last_cm,object_last_ci95_"
      "cm,"
      "paper_ate_rmse_cm,paper_ate_std_cm,paper_loop_closures,paper_optimization_ms\n";
  for (const Cell& c : cells) {
    text +=
        c.dataset + "," + c.odometry + "," + c.setup + "," + std::to_string(c.ate_rmse_cm.count);
    for (const MeanInterval* m :
         {&c.ate_rmse_cm, &c.ate_std_cm, &c.odometry_ate_cm, &c.loop_closures, &c.optimization_ms,
          &c.optimization_cpu_ms, &c.entity_first_cm, &c.entity_last_cm})
      text += "," + csv(*m);
    if (const PaperRow* row = paper.find(c.dataset, c.setup))
      text += "," + exactNumber(row->ate_rmse_cm) + "," + exactNumber(row->ate_std_cm) + "," +
              std::to_string(row->loop_closures) + "," + exactNumber(row->optimization_ms) + "\n";
    else
      text += ",,,,\n";
  }
  return text;
}

std::string entitiesCsv(const std::vector<RunResult>& results) {
  std::string text = "dataset,seed,odometry,setup,entity_id,class,first_error_m,last_error_m\n";
  for (const RunResult& r : results) {
    for (const EntityResult& e : r.entities)
      text += r.key.dataset + "," + std::to_string(r.key.seed) + "," + r.key.odometry + "," +
              r.key.setup + "," + std::to_string(e.id) + "," + e.semantic_class + "," +
              exactNumber(e.first_m) + "," + exactNumber(e.last_m) + "\n";
  }
  return text;
}

}  // namespace dynemo::experiments
