// A room to simulate in, and files to write to.
#pragma once

#include <filesystem>
#include <string>

#include "dynemo/simulation/world.h"

namespace dynemo::simulation::test {

/// One room with a door to another, a table, two boxes of which one moves, a walking human; coarse
/// sensors.
std::string smallWorldYaml();
World smallWorld();

/// Replaces one part of the small world's text. Throws std::logic_error when it is not there
/// exactly once.
std::string changed(const std::string& part, const std::string& by);

/// A folder of its own, removed at the end.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

std::string readBytes(const std::filesystem::path& file);

}  // namespace dynemo::simulation::test
