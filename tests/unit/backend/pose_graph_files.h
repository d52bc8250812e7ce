// Where the public pose graphs are.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

namespace dynemo::test {

/// A file of the folder that DYNEMO_POSE_GRAPHS names; empty when the variable is not set or the
/// file is not there.
inline std::optional<std::filesystem::path> largePoseGraph(const std::string& name) {
  const char* folder = std::getenv("DYNEMO_POSE_GRAPHS");
  if (!folder || !*folder) return std::nullopt;
  const auto file = std::filesystem::path(folder) / name;
  return std::filesystem::exists(file) ? std::optional(file) : std::nullopt;
}

}  // namespace dynemo::test
