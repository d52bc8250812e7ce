#include "dynemo/batch/summary.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "dynemo/core/error.h"
#include "dynemo/evaluation/run_report.h"

namespace dynemo {

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::json;

Json readJson(const fs::path& file) {
  std::ifstream in(file);
  return Json::parse(in, nullptr, false);
}

std::string fixed(double value, int digits) {
  if (!std::isfinite(value)) return {};
  char text[48];
  std::snprintf(text, sizeof(text), "%.*f", digits, value);
  return text;
}

/// The text of a number in a document, empty when it is not there.
std::string number(const Json& json, const Json::json_pointer& at, int digits = 0) {
  const Json value = json.is_object() ? json.value(at, Json()) : Json();
  return value.is_number() ? fixed(value.get<double>(), digits) : std::string();
}

struct EntityCounts {
  std::size_t entities = 0, observations = 0, moved = 0;
};

EntityCounts entityCounts(const Json& summary) {
  EntityCounts counts;
  const Json entities = summary.is_object() ? summary.value("entities", Json::array()) : Json();
  for (const Json& entity : entities) {
    ++counts.entities;
    counts.observations += entity.value("observations", std::size_t{0});
    const bool object = entity.value("class", "") == "object";
    counts.moved += object && entity.value("moved", false) ? 1 : 0;
  }
  return counts;
}

std::string doubtsText(const Json& summary) {
  std::string text;
  const Json doubts = summary.is_object() ? summary.value("doubts", Json::array()) : Json();
  for (const Json& doubt : doubts)
    if (doubt.is_string()) text += (text.empty() ? "" : "; ") + doubt.get<std::string>();
  return text;
}

/// The cells that ground truth fills.
std::vector<std::string> evaluation(const WorkItem& item, const fs::path& folder,
                                    std::string& note) {
  std::vector<std::string> cells(8);
  if (item.trajectory_truth.empty()) return cells;
  try {
    const Trajectory reference = readTum(item.trajectory_truth);
    std::optional<EntityTruths> truths;
    // A run whose outputs leave the entities out still has a trajectory to judge.
    if (!item.entity_truth.empty() && fs::exists(folder / "entities.csv"))
      truths = readEntityTruths(item.entity_truth);
    const RunReport report = evaluateRun(folder, reference, truths ? &*truths : nullptr);
    constexpr double kDeg = 180.0 / std::numbers::pi;
    cells[0] = fixed(report.trajectory.ate_m.rmse, 4);
    if (report.odometry) cells[1] = fixed(report.odometry->ate_m.rmse, 4);
    cells[2] = fixed(report.trajectory.per_meter.translation_m.rmse, 4);
    cells[3] = fixed(report.trajectory.per_meter.rotation_rad.rmse * kDeg, 3);
    if (!report.entities || report.entities->errors.nodes.empty()) return cells;
    cells[4] =
        fixed(finalErrors(report.entities->errors, SemanticClass::kObject).translation_m.rmse, 4);
    cells[5] =
        fixed(finalErrors(report.entities->errors, SemanticClass::kAgent).translation_m.rmse, 4);
    cells[6] = fixed(report.entities->changes.by_object.precision(), 3);
    cells[7] = fixed(report.entities->changes.by_object.recall(), 3);
  } catch (const DataError& e) {
    note += std::string(note.empty() ? "" : "; ") + "not evaluated: " + e.what();
  }
  return cells;
}

std::vector<std::string> summaryRow(const WorkItem& item, const RunStore& store) {
  const std::string rawlog = fs::path(item.name).parent_path().string();
  const RunState state = store.state(item);
  if (state != RunState::kDone) {
    std::vector<std::string> row = {rawlog, item.setup,
                                    state == RunState::kFailed ? "failed" : "missing"};
    row.resize(16);
    row.push_back(state == RunState::kFailed ? store.failure(item) : "");
    return row;
  }
  const fs::path folder = store.folder(item);
  const Json summary = readJson(folder / "summary.json");
  const EntityCounts counts = entityCounts(summary);
  std::vector<std::string> row = {rawlog,
                                  item.setup,
                                  "done",
                                  number(summary, Json::json_pointer("/frames")),
                                  number(summary, Json::json_pointer("/keyframes/count")),
                                  std::to_string(counts.entities),
                                  std::to_string(counts.observations),
                                  std::to_string(counts.moved)};
  std::string note = doubtsText(summary);
  for (std::string& cell : evaluation(item, folder, note)) row.push_back(std::move(cell));
  row.push_back(note);
  return row;
}

std::string csvCell(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

/// Characters, not bytes.
std::size_t width(const std::string& text) {
  std::size_t count = 0;
  for (const char c : text) count += (static_cast<unsigned char>(c) & 0xC0) != 0x80 ? 1 : 0;
  return count;
}

}  // namespace

Table summaryTable(const std::vector<WorkItem>& items, const RunStore& store) {
  Table table{{"rawlog", "setup", "state", "frames", "keyframes", "entities", "observations",
               "moved", "ate_m", "odometry_ate_m", "rpe_m", "rpe_deg", "objects_m", "agents_m",
               "moved_precision", "moved_recall", "note"},
              {}};
  for (const WorkItem& item : items) table.rows.push_back(summaryRow(item, store));
  return table;
}

Table performanceTable(const std::vector<WorkItem>& items, const RunStore& store) {
  Table table{{"rawlog", "setup", "dataset_s", "wall_s", "cpu_s", "real_time_factor", "peak_rss_mb",
               "optimization_ms"},
              {}};
  for (const WorkItem& item : items) {
    if (store.state(item) != RunState::kDone) continue;
    const Json json = readJson(store.folder(item) / "performance.json");
    std::vector<std::string> row = {fs::path(item.name).parent_path().string(), item.setup};
    for (const char* key : {"/dataset_s", "/wall_s", "/cpu_s", "/real_time_factor", "/peak_rss_mb",
                            "/optimization_ms"})
      row.push_back(number(json, Json::json_pointer(key), 2));
    table.rows.push_back(std::move(row));
  }
  return table;
}

std::string tableCsv(const Table& table) {
  std::string text;
  const auto line = [&](const std::vector<std::string>& cells) {
    for (std::size_t i = 0; i < cells.size(); ++i) text += (i > 0 ? "," : "") + csvCell(cells[i]);
    text += "\n";
  };
  line(table.columns);
  for (const auto& row : table.rows) line(row);
  return text;
}

std::string tableText(const Table& table) {
  // Columns without any content are left out.
  std::vector<std::size_t> widths(table.columns.size(), 0);
  for (const auto& row : table.rows)
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], width(row[i]));
  for (std::size_t i = 0; i < widths.size(); ++i)
    if (widths[i] > 0) widths[i] = std::max(widths[i], width(table.columns[i]));
  std::string text;
  const auto line = [&](const std::vector<std::string>& cells) {
    std::string row;
    for (std::size_t i = 0; i < cells.size(); ++i)
      if (widths[i] > 0) row += cells[i] + std::string(widths[i] - width(cells[i]) + 2, ' ');
    row.erase(row.find_last_not_of(' ') + 1);
    text += row + "\n";
  };
  line(table.columns);
  for (const auto& row : table.rows) line(row);
  return text;
}

}  // namespace dynemo
