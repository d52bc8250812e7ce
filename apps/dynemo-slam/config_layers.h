#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "dynemo/pipeline/params.h"

namespace dynemo {

/// Layers of configuration, weakest first: config/default.yaml's values (built in), the setup, the
/// user's file, --set.
struct ConfigLayers {
  std::optional<std::string> setup;
  std::optional<std::filesystem::path> file;
  std::vector<std::string> overrides;
};

/// Throws ConfigError for an unknown setup (listing the known ones) and for every wrong key or
/// value at once.
DynemoParams loadParams(const ConfigLayers& layers);

/// Names of the installed setups, for --help and messages.
std::vector<std::string> setupNames();

}  // namespace dynemo
