#include "dynemo/evaluation/entity_data.h"

#include <algorithm>

#include "text_input.h"

namespace dynemo {
namespace {

constexpr const char* kAxes[] = {"x", "y", "z", "rx", "ry", "rz"};

SemanticClass readClass(const CsvTable& table, std::size_t row) {
  const std::string& text = table.text(row, "class");
  for (const SemanticClass c : {SemanticClass::kObject, SemanticClass::kAgent}) {
    if (text == semanticClassName(c)) return c;
  }
  table.fail(row, "class: '" + text + "' is neither object nor agent");
}

std::optional<Matrix6> readCovariance(const CsvTable& table, std::size_t row) {
  if (!table.hasColumn("var_x") || table.text(row, "var_x").empty()) return std::nullopt;
  Matrix6 covariance;
  for (int r = 0; r < 6; ++r) {
    covariance(r, r) = table.number(row, std::string("var_") + kAxes[r]);
    for (int c = r + 1; c < 6; ++c) {
      covariance(r, c) = covariance(c, r) =
          table.number(row, std::string("cov_") + kAxes[r] + "_" + kAxes[c]);
    }
  }
  return covariance;
}

EntityEstimate readEstimate(const CsvTable& table, std::size_t row) {
  EntityEstimate e;
  const std::int64_t node = table.integer(row, "node_id");
  if (node < 0) table.fail(row, "node_id: must not be negative");
  e.node = {static_cast<std::uint64_t>(node)};
  e.entity = {table.integer(row, "entity_id")};
  e.semantic_class = readClass(table, row);
  e.name = table.text(row, "name");
  e.stamp = table.stamp(row, "timestamp");
  e.moved = table.integer(row, "moved") != 0;
  e.T_map_entity = table.pose(row, "");
  e.T_map_entity_first = table.pose(row, "first_");
  e.covariance = readCovariance(table, row);
  return e;
}

}  // namespace

std::vector<EntityEstimate> readEntityEstimates(const std::filesystem::path& file) {
  const CsvTable table(readTextFile(file), file.string());
  std::vector<EntityEstimate> list;
  for (std::size_t row = 0; row < table.rows(); ++row) list.push_back(readEstimate(table, row));
  return list;
}

EntityTruths readEntityTruths(const std::filesystem::path& file) {
  const CsvTable table(readTextFile(file), file.string());
  EntityTruths truths;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    EntityTruth& truth = truths[{table.integer(row, "entity_id")}];
    truth.semantic_class = readClass(table, row);
    truth.poses.push_back({table.stamp(row, "timestamp"), table.pose(row, "")});
  }
  for (auto& [id, truth] : truths) {
    std::stable_sort(truth.poses.begin(), truth.poses.end(),
                     [](const auto& a, const auto& b) { return a.stamp < b.stamp; });
  }
  return truths;
}

}  // namespace dynemo
