// Everything the evaluator says about one run.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "dynemo/evaluation/entity_change.h"
#include "dynemo/evaluation/loop_error.h"
#include "dynemo/evaluation/trajectory_error.h"

namespace dynemo {

struct TrajectoryReport {
  Statistics ate_m;
  RelativePoseErrors per_meter;
  RelativePoseErrors per_frame;
  Pose3 T_reference_estimate;
};

/// Throws DataError, naming both files, when too few poses correspond or the alignment is not
/// determined.
TrajectoryReport evaluateTrajectory(const Trajectory& reference, const Trajectory& estimate,
                                    const std::string& name);

struct EntityReport {
  EntityErrors errors;
  ChangeReport changes;
  MotionErrors object_motions, agent_motions;
};

struct RunReport {
  std::string run;
  TrajectoryReport trajectory;
  /// Where the run has the file.
  std::optional<TrajectoryReport> keyframes, odometry;
  std::optional<EntityReport> entities;
  std::optional<LoopReport> loops;
};

/// `run` is a run's folder or one TUM file. Throws DataError when a file is missing or malformed.
RunReport evaluateRun(const std::filesystem::path& run, const Trajectory& reference,
                      const EntityTruths* truths);

/// As tables to read; cm and degrees.
std::string reportText(const RunReport& report);

/// As JSON: metres and degrees, as the keys say; null where there is no figure.
std::string reportJson(const RunReport& report);

}  // namespace dynemo
