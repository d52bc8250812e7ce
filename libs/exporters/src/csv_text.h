#pragma once

#include <string>

namespace dynemo {

/// Quoted as RFC 4180 asks when the text holds a separator.
inline std::string csvText(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

}  // namespace dynemo
