// A small CSV file with a header.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace dynemo::experiments {

class CsvTable {
 public:
  /// Throws DataError when the file cannot be read, or a row has another number of cells than the
  /// header.
  static CsvTable read(const std::filesystem::path& file);

  std::size_t rows() const { return cells_.size(); }
  /// Throws DataError when there is no such column.
  const std::string& text(std::size_t row, const std::string& column) const;
  /// Throws DataError when the cell is not a number.
  double number(std::size_t row, const std::string& column) const;

 private:
  std::string origin_;
  std::vector<std::string> header_;
  std::vector<std::vector<std::string>> cells_;
};

}  // namespace dynemo::experiments
