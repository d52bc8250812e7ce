#include "dynemo/batch/work_list.h"

#include <glob.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "dynemo/core/error.h"

namespace dynemo {

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;

std::vector<fs::path> expandPattern(const std::string& word) {
  std::error_code ignored;
  if (fs::is_regular_file(word, ignored)) return {word};
  glob_t found{};
  const int result = ::glob(word.c_str(), 0, nullptr, &found);
  std::vector<fs::path> files;
  if (result == 0)
    for (std::size_t i = 0; i < found.gl_pathc; ++i)
      if (fs::is_regular_file(found.gl_pathv[i], ignored)) files.emplace_back(found.gl_pathv[i]);
  globfree(&found);
  if (files.empty()) throw DataError(word + ": no such file, and no file that fits");
  return files;
}

std::vector<fs::path> expandList(const fs::path& list) {
  std::ifstream in(list);
  if (!in) throw DataError(list.string() + ": cannot be read");
  std::vector<fs::path> files;
  for (std::string line; std::getline(in, line);) {
    const auto begin = line.find_first_not_of(" \t\r");
    if (begin == std::string::npos || line[begin] == '#') continue;
    const auto end = line.find_last_not_of(" \t\r");
    const fs::path word = line.substr(begin, end - begin + 1);
    for (auto& file : expandPattern(word.is_absolute() ? word : list.parent_path() / word))
      files.push_back(std::move(file));
  }
  if (files.empty()) throw DataError(list.string() + ": lists no rawlog");
  return files;
}

/// The file beside the rawlog, when it exists.
std::string beside(const fs::path& rawlog, const char* suffix) {
  const fs::path file = rawlog.parent_path() / (rawlog.stem().string() + suffix);
  std::error_code ignored;
  return fs::is_regular_file(file, ignored) ? file.string() : std::string();
}

/// The rawlogs' names: the stem, or with that of the folder where stems are not unique.
std::vector<std::string> rawlogNames(const std::vector<fs::path>& rawlogs) {
  std::map<std::string, int> times;
  for (const fs::path& rawlog : rawlogs) ++times[rawlog.stem().string()];
  std::vector<std::string> names;
  for (const fs::path& rawlog : rawlogs) {
    const std::string stem = rawlog.stem().string();
    names.push_back(times[stem] == 1 ? stem
                                     : rawlog.parent_path().filename().string() + "-" + stem);
  }
  return names;
}

bool isConfigFile(const std::string& setup) {
  return setup.ends_with(".yaml") || setup.ends_with(".yml");
}

std::string setupName(const std::string& setup) {
  return isConfigFile(setup) ? fs::path(setup).stem().string() : setup;
}

std::vector<std::string> argumentsFor(const fs::path& rawlog, const std::string& setup,
                                      const WorkPlan& plan) {
  std::vector<std::string> arguments;
  const auto add = [&](const char* option, const std::string& value) {
    arguments.emplace_back(option);
    arguments.push_back(value);
  };
  if (isConfigFile(setup))
    add("--config", fs::absolute(setup).string());
  else if (!setup.empty())
    add("--setup", setup);
  if (plan.config) add("--config", fs::absolute(*plan.config).string());
  for (const std::string& override_text : plan.overrides) add("--set", override_text);
  const std::string entities =
      plan.entities ? fs::absolute(*plan.entities).string() : beside(rawlog, "_entities.yaml");
  if (!entities.empty()) add("--entities", entities);
  arguments.push_back(rawlog.string());
  return arguments;
}

}  // namespace

std::vector<fs::path> expandRawlogs(const std::vector<std::string>& words) {
  std::vector<fs::path> all;
  std::set<fs::path> seen;
  for (const std::string& word : words) {
    const auto files = word.starts_with('@') ? expandList(word.substr(1)) : expandPattern(word);
    for (const fs::path& file : files) {
      const fs::path absolute = fs::absolute(file).lexically_normal();
      if (seen.insert(absolute).second) all.push_back(absolute);
    }
  }
  return all;
}

std::vector<WorkItem> makeWorkList(const std::vector<fs::path>& rawlogs, const WorkPlan& plan) {
  const std::vector<std::string> setups =
      plan.setups.empty() ? std::vector<std::string>{""} : plan.setups;
  for (const std::string& setup : setups)
    if (isConfigFile(setup) && plan.config)
      throw ConfigError("--config: cannot be combined with the configuration file " + setup +
                        " as a setup");
  const auto names = rawlogNames(rawlogs);
  std::vector<WorkItem> items;
  std::set<std::string> taken;
  for (std::size_t i = 0; i < rawlogs.size(); ++i)
    for (const std::string& setup : setups) {
      WorkItem item;
      item.setup = setup.empty() ? "default" : setupName(setup);
      item.name = names[i] + "/" + item.setup;
      item.rawlog = rawlogs[i].string();
      item.arguments = argumentsFor(rawlogs[i], setup, plan);
      item.trajectory_truth = beside(rawlogs[i], "_gt_robot.tum");
      item.entity_truth = beside(rawlogs[i], "_gt_entities.csv");
      if (!taken.insert(item.name).second)
        throw ConfigError("two runs would be called " + item.name +
                          ": setups and rawlogs need names of their own");
      items.push_back(std::move(item));
    }
  return items;
}

std::vector<std::string> rawlogsWithoutEntities(const std::vector<WorkItem>& items) {
  std::vector<std::string> rawlogs;
  for (const WorkItem& item : items) {
    const auto& a = item.arguments;
    const bool without = std::find(a.begin(), a.end(), "--entities") == a.end();
    // Runs of one rawlog follow each other.
    if (without && (rawlogs.empty() || rawlogs.back() != item.rawlog))
      rawlogs.push_back(item.rawlog);
  }
  return rawlogs;
}

std::string workListJson(const std::vector<WorkItem>& items) {
  Json json = Json::array();
  for (const WorkItem& item : items)
    json.push_back({{"name", item.name},
                    {"rawlog", item.rawlog},
                    {"setup", item.setup},
                    {"arguments", item.arguments},
                    {"trajectory_truth", item.trajectory_truth},
                    {"entity_truth", item.entity_truth}});
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::vector<WorkItem> readWorkList(const fs::path& file) {
  std::ifstream in(file);
  if (!in) throw DataError(file.string() + ": cannot be read");
  try {
    std::vector<WorkItem> items;
    for (const auto& json : Json::parse(in))
      items.push_back({json.at("name").get<std::string>(), json.at("rawlog").get<std::string>(),
                       json.at("setup").get<std::string>(),
                       json.at("arguments").get<std::vector<std::string>>(),
                       json.at("trajectory_truth").get<std::string>(),
                       json.at("entity_truth").get<std::string>()});
    return items;
  } catch (const nlohmann::json::exception& e) {
    throw DataError(file.string() + ": is no work list: " + e.what());
  }
}

}  // namespace dynemo
