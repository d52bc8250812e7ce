#include "dynemo/experiments/csv_table.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <sstream>

#include "dynemo/core/error.h"

namespace dynemo::experiments {
namespace {

std::vector<std::string> split(std::string line) {
  if (!line.empty() && line.back() == '\r') line.pop_back();
  std::vector<std::string> cells;
  std::istringstream in(line);
  for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
  if (!line.empty() && line.back() == ',') cells.emplace_back();
  return cells;
}

}  // namespace

CsvTable CsvTable::read(const std::filesystem::path& file) {
  std::ifstream in(file);
  CsvTable table;
  table.origin_ = file.string();
  std::string line;
  if (!std::getline(in, line)) throw DataError(table.origin_ + ": cannot be read or is empty");
  table.header_ = split(line);
  while (std::getline(in, line)) {
    if (line.empty()) continue;
    table.cells_.push_back(split(line));
    if (table.cells_.back().size() != table.header_.size())
      throw DataError(table.origin_ + ": row " + std::to_string(table.rows()) + " has " +
                      std::to_string(table.cells_.back().size()) + " cells, the header " +
                      std::to_string(table.header_.size()));
  }
  return table;
}

const std::string& CsvTable::text(std::size_t row, const std::string& column) const {
  const auto it = std::find(header_.begin(), header_.end(), column);
  if (it == header_.end()) throw DataError(origin_ + ": has no column '" + column + "'");
  return cells_.at(row)[static_cast<std::size_t>(it - header_.begin())];
}

double CsvTable::number(std::size_t row, const std::string& column) const {
  const std::string& cell = text(row, column);
  double value = 0.0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc() || end != cell.data() + cell.size())
    throw DataError(origin_ + ": row " + std::to_string(row + 1) + ": " + column + ": '" + cell +
                    "' is not a number");
  return value;
}

}  // namespace dynemo::experiments
