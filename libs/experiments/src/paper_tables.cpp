#include "dynemo/experiments/paper_tables.h"

#include "dynemo/experiments/csv_table.h"
#include "dynemo/experiments/experiment_plan.h"

namespace dynemo::experiments {

PaperTables PaperTables::read(const std::filesystem::path& folder) {
  PaperTables tables;
  const CsvTable ate = CsvTable::read(folder / "ate.csv");
  for (std::size_t i = 0; i < ate.rows(); ++i) {
    tables.rows_[{ate.text(i, "dataset"), ate.text(i, "setup")}] = {
        ate.number(i, "ate_rmse_cm"), ate.number(i, "ate_std_cm"),
        ate.number(i, "optimization_time_ms"), static_cast<int>(ate.number(i, "loop_closures"))};
  }
  const CsvTable entities = CsvTable::read(folder / "entity_errors.csv");
  for (std::size_t i = 0; i < entities.rows(); ++i) {
    tables.entities_.push_back({static_cast<int>(entities.number(i, "entity_id")),
                                entities.text(i, "dataset"), entities.number(i, "first_error_cm"),
                                entities.number(i, "last_error_cm")});
  }
  return tables;
}

const PaperRow* PaperTables::find(const std::string& dataset, const std::string& setup) const {
  const auto it = rows_.find({dataset, paperName(setup)});
  return it == rows_.end() ? nullptr : &it->second;
}

std::optional<double> PaperTables::meanCut(const std::vector<std::string>& datasets) const {
  double sum = 0.0;
  int count = 0;
  for (const std::string& dataset : datasets) {
    const PaperRow *full = find(dataset, "full"), *baseline = find(dataset, "baseline");
    if (full == nullptr || baseline == nullptr) continue;
    sum += 1.0 - full->ate_rmse_cm / baseline->ate_rmse_cm;
    ++count;
  }
  if (count == 0) return std::nullopt;
  return sum / count;
}

}  // namespace dynemo::experiments
