#include "text_table.h"

#include <algorithm>

namespace dynemo {
namespace {

bool isNumber(const std::string& text) {
  return !text.empty() && text.find_first_not_of("+-.0123456789") == std::string::npos;
}

std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xc0u) != 0x80u;  // UTF-8 characters, not bytes
  }));
}

std::string padded(const std::string& text, std::size_t columns, bool right) {
  const std::string blanks(columns - width(text), ' ');
  return right ? blanks + text : text + blanks;
}

}  // namespace

std::string textTable(const TableRow& header, const std::vector<TableRow>& rows) {
  std::vector<std::size_t> widths;
  std::vector<bool> right;
  for (std::size_t c = 0; c < header.size(); ++c) {
    widths.push_back(width(header[c]));
    bool numbers = !rows.empty();
    for (const TableRow& row : rows) {
      widths[c] = std::max(widths[c], width(row[c]));
      numbers = numbers && (row[c] == "-" || isNumber(row[c]));
    }
    right.push_back(numbers);
  }
  const auto line = [&](const TableRow& row) {
    std::string text;
    for (std::size_t c = 0; c < row.size(); ++c) {
      text += (c == 0 ? "" : "  ") + padded(row[c], widths[c], right[c]);
    }
    return text.substr(0, text.find_last_not_of(' ') + 1) + '\n';
  };
  std::string text = line(header);
  for (const TableRow& row : rows) text += line(row);
  return text;
}

}  // namespace dynemo
