// What a batch has to do: one dynemo-slam run for each rawlog and setup.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace dynemo {

/// One run. Paths are absolute, so that it can be started anywhere on any machine that shares the
/// files.
struct WorkItem {
  std::string name{};    ///< of its folder, unique: "RAWLOG/SETUP"
  std::string rawlog{};  ///< file
  std::string setup{};   ///< for the table
  /// Arguments of dynemo-slam without --output.
  std::vector<std::string> arguments{};
  /// Ground truth beside the rawlog; empty when there is none.
  std::string trajectory_truth{}, entity_truth{};
};

/// How dynemo-slam is to be called for each rawlog.
struct WorkPlan {
  /// Names of setups, or configuration files (*.yaml), which are then named by their stem; empty:
  /// one run with dynemo-slam's defaults.
  std::vector<std::string> setups;
  std::optional<std::filesystem::path> config;
  std::vector<std::string> overrides;  ///< KEY=VALUE
  /// Entity file for every rawlog; empty: NAME_entities.yaml beside each, where there is one.
  std::optional<std::filesystem::path> entities;
};

/// The files that the words name: each is a file, a pattern as of the shell, or, when it begins
/// with '@', a text file with one such word per line (empty lines and # skipped; relative to that
/// file). Sorted within a pattern, without repetition. Throws DataError when a word names nothing.
std::vector<std::filesystem::path> expandRawlogs(const std::vector<std::string>& words);

/// All rawlogs times all setups, in this order. Rawlogs of the same name get that of their folder
/// in front. Throws ConfigError when a setup is given twice or two runs would share a folder.
std::vector<WorkItem> makeWorkList(const std::vector<std::filesystem::path>& rawlogs,
                                   const WorkPlan& plan);

/// The rawlogs whose runs have no entity file, each once.
std::vector<std::string> rawlogsWithoutEntities(const std::vector<WorkItem>& items);

std::string workListJson(const std::vector<WorkItem>& items);
/// Throws DataError when the file is not what workListJson() writes.
std::vector<WorkItem> readWorkList(const std::filesystem::path& file);

}  // namespace dynemo
