#include "text_input.h"

#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "dynemo/core/error.h"

namespace dynemo {

namespace fs = std::filesystem;

std::string readTextFile(const fs::path& file) {
  std::error_code ignored;
  if (fs::is_directory(file, ignored)) {
    throw DataError(file.string() + ": is a folder, not a file");
  }
  std::ifstream in(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  if (!in) throw DataError(file.string() + ": cannot be read: no such file, or no permission");
  return text;
}

std::optional<double> finiteNumber(const std::string& text) {
  const char* first = text.data() + (text.starts_with('+') ? 1 : 0);
  const char* last = text.data() + text.size();
  double value = 0.0;
  const auto [end, error] = std::from_chars(first, last, value);
  if (error != std::errc() || end != last || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<Pose3> poseFromColumns(const double* v) {
  const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
  if (!(q.norm() > 1e-6)) return std::nullopt;
  return Pose3(q, Vector3(v[0], v[1], v[2]));
}

void failAt(const std::string& origin, std::size_t line, const std::string& problem) {
  throw DataError(origin + ":" + std::to_string(line) + ": " + problem);
}

CsvTable::CsvTable(const std::string& text, std::string origin)
    : origin_(std::move(origin)), rows_(split(text)) {
  if (rows_.empty()) throw DataError(origin_ + ": is empty; expected a line with column names");
  const Row header = rows_.front();
  rows_.erase(rows_.begin());
  for (std::size_t i = 0; i < header.values.size(); ++i) columns_[header.values[i]] = i;
  for (const Row& row : rows_) {
    if (row.values.size() == header.values.size()) continue;
    failAt(origin_, row.line,
           std::to_string(row.values.size()) + " columns; the first line has " +
               std::to_string(header.values.size()));
  }
}

std::vector<CsvTable::Row> CsvTable::split(const std::string& text) {
  std::vector<Row> rows;
  Row row{1, {""}};
  std::size_t line = 1;
  bool quoted = false;
  const auto finish = [&] {
    const bool blank = row.values.size() == 1 && row.values.front().empty();
    if (!blank) rows.push_back(std::move(row));
    row = {line, {""}};
  };
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '\n') ++line;
    if (quoted) {
      if (c != '"') {
        row.values.back() += c;
      } else if (i + 1 < text.size() && text[i + 1] == '"') {
        row.values.back() += text[++i];
      } else {
        quoted = false;
      }
    } else if (c == '"') {
      quoted = true;
    } else if (c == ',') {
      row.values.emplace_back();
    } else if (c == '\n') {
      finish();
    } else if (c != '\r') {
      row.values.back() += c;
    }
  }
  finish();
  return rows;
}

void CsvTable::fail(std::size_t row, const std::string& problem) const {
  failAt(origin_, rows_.at(row).line, problem);
}

const std::string& CsvTable::text(std::size_t row, const std::string& column) const {
  const auto it = columns_.find(column);
  if (it == columns_.end()) throw DataError(origin_ + ": has no column '" + column + "'");
  return rows_.at(row).values.at(it->second);
}

double CsvTable::number(std::size_t row, const std::string& column) const {
  const std::string& value = text(row, column);
  const auto number = finiteNumber(value);
  if (!number) fail(row, column + ": '" + value + "' is not a finite number");
  return *number;
}

std::int64_t CsvTable::integer(std::size_t row, const std::string& column) const {
  const std::string& value = text(row, column);
  std::int64_t number = 0;
  const char* last = value.data() + value.size();
  const auto [end, error] = std::from_chars(value.data(), last, number);
  if (error != std::errc() || end != last) {
    fail(row, column + ": '" + value + "' is not a whole number");
  }
  return number;
}

Stamp CsvTable::stamp(std::size_t row, const std::string& column) const {
  try {
    return Stamp::parse(text(row, column));
  } catch (const std::invalid_argument& e) {
    fail(row, column + ": " + e.what());
  }
}

Pose3 CsvTable::pose(std::size_t row, const std::string& prefix) const {
  double values[7];
  int i = 0;
  for (const char* name : {"x", "y", "z", "qx", "qy", "qz", "qw"}) {
    values[i++] = number(row, prefix + name);
  }
  const auto pose = poseFromColumns(values);
  if (!pose) fail(row, "a quaternion of length zero");
  return *pose;
}

}  // namespace dynemo
