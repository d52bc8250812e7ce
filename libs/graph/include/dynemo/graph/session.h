#pragma once

#include <filesystem>
#include <string>

#include "dynemo/graph/scene_graph.h"

namespace dynemo {

/// A whole mapping session: the graph with its drift, the effective configuration and the
/// keyframes' clouds.
struct Session {
  CSceneGraph graph;
  std::string config_yaml;
};

/// Writes the session into a folder (created when missing): graph.bin, config.yaml,
/// clouds/NNNNNN.bin. Saving what was loaded gives the same bytes. Throws DataError, leaving an
/// earlier graph.bin in place, when it cannot be written.
void saveSession(const Session& session, const std::filesystem::path& folder);

/// Reads it back, clouds included. Throws DataError naming the file that is missing or damaged.
Session loadSession(const std::filesystem::path& folder);

}  // namespace dynemo
