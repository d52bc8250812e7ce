#include "dynemo/experiments/experiment_plan.h"

#include <algorithm>

#include "dynemo/core/error.h"

namespace dynemo::experiments {

void fields(FieldVisitor& v, ExperimentPlan& p) {
  v.texts("datasets", p.datasets, "Datasets of dynemo-simulate");
  v.texts("setups", p.setups, "Setups of dynemo-slam");
  v.texts("odometries", p.odometries,
          "Methods of LiDAR odometry, keyframe_gicp being the baseline's; or rawlog");
  v.integer("seeds", p.seeds, "Datasets of each kind, seeds 1, 2, …", Range::between(1, 1000));
  v.text("scale", p.scale, "Of the datasets: mini or full");
  v.optionalNumber("duration_s", p.duration_s, "Length instead of the datasets' own",
                   Range::positive());
  v.flag("keep_rawlogs", p.keep_rawlogs, "Keep rawlogs and images after the runs");
}

const std::vector<SetupName>& setupNames() {
  static const std::vector<SetupName> names{
      {"baseline", "baseline"}, {"only-kf-e", "only KF-E"},
      {"intra-e", "intra-E"},   {"f-e", "F-E"},
      {"fcs", "FCS"},           {"always-epcr", "always EPCR"},
      {"mb-epcr", "MB-EPCR"},   {"full", "Full"}};
  return names;
}

std::string paperName(const std::string& setup) {
  const auto it = std::find_if(setupNames().begin(), setupNames().end(),
                               [&](const SetupName& n) { return n.setup == setup; });
  return it == setupNames().end() ? setup : it->paper;
}

std::string RunKey::path() const {
  return dataset + "/seed" + std::to_string(seed) + "/" + odometry + "/" + setup;
}

std::vector<RunKey> runsOf(const ExperimentPlan& plan) {
  if (plan.datasets.empty()) throw ConfigError("datasets: none given");
  if (plan.setups.empty()) throw ConfigError("setups: none given");
  if (plan.odometries.empty()) throw ConfigError("odometries: none given");
  if (plan.scale != "mini" && plan.scale != "full")
    throw ConfigError("scale: '" + plan.scale + "' must be mini or full");
  std::vector<RunKey> runs;
  for (const std::string& dataset : plan.datasets)
    for (int seed = 1; seed <= plan.seeds; ++seed)
      for (const std::string& odometry : plan.odometries)
        for (const std::string& setup : plan.setups)
          runs.push_back({dataset, seed, odometry, setup});
  return runs;
}

}  // namespace dynemo::experiments
