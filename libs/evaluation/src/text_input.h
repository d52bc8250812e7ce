// Reading of text files with messages that name file and line.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "dynemo/core/se3.h"
#include "dynemo/core/time.h"

namespace dynemo {

/// The whole file; throws DataError when it cannot be read.
std::string readTextFile(const std::filesystem::path& file);

/// A finite decimal number that fills the text, or nothing.
std::optional<double> finiteNumber(const std::string& text);

/// Position and quaternion columns as a pose; nothing when the quaternion has no length.
std::optional<Pose3> poseFromColumns(const double* x_y_z_qx_qy_qz_qw);

/// Throws DataError "origin:line: problem".
[[noreturn]] void failAt(const std::string& origin, std::size_t line, const std::string& problem);

/// Comma-separated values with quoting as in RFC 4180; the first record names the columns.
class CsvTable {
 public:
  CsvTable(const std::string& text, std::string origin);

  std::size_t rows() const { return rows_.size(); }
  bool hasColumn(const std::string& column) const { return columns_.contains(column); }

  /// Each throws DataError naming file, line and column when the column is missing or the value is
  /// not of the type.
  const std::string& text(std::size_t row, const std::string& column) const;
  double number(std::size_t row, const std::string& column) const;
  std::int64_t integer(std::size_t row, const std::string& column) const;
  Stamp stamp(std::size_t row, const std::string& column) const;
  /// From the columns x y z qx qy qz qw, each with the prefix.
  Pose3 pose(std::size_t row, const std::string& prefix) const;

  [[noreturn]] void fail(std::size_t row, const std::string& problem) const;

 private:
  struct Row {
    std::size_t line = 0;
    std::vector<std::string> values;
  };
  static std::vector<Row> split(const std::string& text);

  std::string origin_;
  std::map<std::string, std::size_t> columns_;
  std::vector<Row> rows_;
};

}  // namespace dynemo
