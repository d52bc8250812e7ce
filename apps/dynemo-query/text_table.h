#pragma once

#include <string>
#include <vector>

namespace dynemo {

using TableRow = std::vector<std::string>;

/// Columns aligned by their widest cell, two blanks between them, numbers to the right.
std::string textTable(const TableRow& header, const std::vector<TableRow>& rows);

}  // namespace dynemo
