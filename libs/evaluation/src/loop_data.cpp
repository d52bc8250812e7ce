#include <yaml-cpp/yaml.h>

#include <algorithm>

#include "dynemo/core/error.h"
#include "dynemo/evaluation/loop_error.h"
#include "text_input.h"

namespace dynemo {

std::vector<LoopEstimate> readLoopEstimates(const std::filesystem::path& file) {
  const CsvTable table(readTextFile(file), file.string());
  std::vector<LoopEstimate> loops;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const std::string& decision = table.text(row, "decision");
    if (decision != "accepted" && decision != "removed") continue;
    const std::int64_t id = table.integer(row, "edge_id");
    if (id < 0) table.fail(row, "edge_id: must not be negative");
    const EdgeId edge{static_cast<std::uint64_t>(id)};
    if (decision == "accepted") {
      loops.push_back({edge, table.stamp(row, "earlier_timestamp"),
                       table.stamp(row, "later_timestamp"), table.pose(row, ""), false});
      continue;
    }
    const auto it = std::find_if(loops.begin(), loops.end(),
                                 [&](const LoopEstimate& loop) { return loop.edge == edge; });
    if (it == loops.end()) table.fail(row, "edge_id: removed but never accepted");
    it->removed = true;
  }
  return loops;
}

std::optional<LoopGate> readLoopGate(const std::filesystem::path& config_yaml) {
  if (!std::filesystem::exists(config_yaml)) return std::nullopt;
  try {
    const YAML::Node loops = YAML::Load(readTextFile(config_yaml))["loops"];
    if (!loops || !loops["enabled"].as<bool>(false)) return std::nullopt;
    const YAML::Node candidates = loops["candidates"];
    return LoopGate{candidates["max_distance_m"].as<double>(),
                    candidates["min_path_m"].as<double>(), candidates["spacing_m"].as<double>()};
  } catch (const YAML::Exception& e) {
    throw DataError(config_yaml.string() + ": loops.candidates: " + e.what());
  }
}

}  // namespace dynemo
