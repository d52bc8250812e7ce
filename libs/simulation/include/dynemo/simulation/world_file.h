// World files: YAML that a user can read, edit and write (share/doc/simulation.md).
#pragma once

#include <filesystem>
#include <string>

#include "dynemo/simulation/world.h"

namespace dynemo::simulation {

/// Throws ConfigError that names file, item, key and constraint: unreadable or malformed file,
/// unknown or missing keys, unknown models, repeated ids or tags, values out of range. Whether the
/// robot has free way is checked by requireFreeWay().
World readWorld(const std::filesystem::path& file);
/// As readWorld, from text; `origin` names it in messages.
World parseWorld(const std::string& yaml, const std::string& origin);

/// Reads back as the same world.
std::string worldYaml(const World& world);

}  // namespace dynemo::simulation
