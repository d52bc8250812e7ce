// Which runs an ablation study consists of.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dynemo/core/fields.h"

namespace dynemo::experiments {

struct ExperimentPlan {
  std::vector<std::string> datasets;
  std::vector<std::string> setups;
  /// How the robot's motion is estimated: registered methods of LiDAR odometry, or "rawlog".
  std::vector<std::string> odometries{"keyframe_gicp", "local_map"};
  int seeds = 2;
  std::string scale = "full";
  std::optional<double> duration_s;
  bool keep_rawlogs = false;
};

void fields(FieldVisitor& v, ExperimentPlan& p);

/// The setups in the order and with the names of the paper's tables.
struct SetupName {
  std::string setup, paper;
};
const std::vector<SetupName>& setupNames();
/// The paper's name of a setup, or the setup itself.
std::string paperName(const std::string& setup);

/// One run of the study.
struct RunKey {
  std::string dataset;
  int seed = 1;
  std::string odometry, setup;

  friend auto operator<=>(const RunKey&, const RunKey&) = default;
  /// DATASET/seedN/ODOMETRY/SETUP.
  std::string path() const;
};

/// Ordered by dataset, seed, odometry, setup as listed. Throws ConfigError when a list is empty, a
/// scale is unknown or there are no seeds.
std::vector<RunKey> runsOf(const ExperimentPlan& plan);

}  // namespace dynemo::experiments
