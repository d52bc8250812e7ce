// The figures of the paper's tables (share/data/paper).
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace dynemo::experiments {

struct PaperRow {
  double ate_rmse_cm = 0, ate_std_cm = 0, optimization_ms = 0;
  int loop_closures = 0;
};

struct PaperEntityRow {
  int entity_id = 0;
  std::string dataset;
  double first_cm = 0, last_cm = 0;
};

class PaperTables {
 public:
  /// Reads ate.csv and entity_errors.csv. Throws DataError when they cannot be read.
  static PaperTables read(const std::filesystem::path& folder);

  /// `setup` as this project calls it.
  const PaperRow* find(const std::string& dataset, const std::string& setup) const;
  const std::vector<PaperEntityRow>& entities() const { return entities_; }
  /// 1 − ATE of Full / ATE of the baseline, averaged over the given datasets that the paper has.
  std::optional<double> meanCut(const std::vector<std::string>& datasets) const;

 private:
  std::map<std::pair<std::string, std::string>, PaperRow> rows_;  ///< by dataset and paper's setup
  std::vector<PaperEntityRow> entities_;
};

}  // namespace dynemo::experiments
