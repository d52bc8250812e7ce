#include "dynemo/evaluation/run_report.h"

#include "dynemo/core/error.h"

namespace dynemo {
namespace {

namespace fs = std::filesystem;

std::optional<TrajectoryReport> evaluateIfPresent(const fs::path& file,
                                                  const Trajectory& reference) {
  if (!fs::exists(file)) return std::nullopt;
  return evaluateTrajectory(reference, readTum(file), file.string());
}

std::optional<LoopReport> evaluateLoopsIfPresent(const fs::path& run, const Trajectory& reference) {
  const fs::path loops = run / "loops.csv", keyframes = run / "keyframes.tum";
  if (!fs::exists(loops) || !fs::exists(keyframes)) return std::nullopt;
  return evaluateLoops(readLoopEstimates(loops), readTum(keyframes), reference,
                       readLoopGate(run / "config.yaml"));
}

EntityReport evaluateEntityFile(const fs::path& file, const EntityTruths& truths,
                                const Pose3& T_world_map) {
  EntityReport report;
  report.errors = evaluateEntities(readEntityEstimates(file), truths, T_world_map);
  report.changes = evaluateChanges(report.errors, truths);
  report.object_motions = evaluateMotions(report.errors, SemanticClass::kObject);
  report.agent_motions = evaluateMotions(report.errors, SemanticClass::kAgent);
  return report;
}

}  // namespace

TrajectoryReport evaluateTrajectory(const Trajectory& reference, const Trajectory& estimate,
                                    const std::string& name) {
  const auto aligned = alignTrajectories(reference, estimate);
  if (!aligned) {
    throw DataError(
        name + ": cannot be aligned with the reference: " + alignmentFailureText(aligned.error()));
  }
  TrajectoryReport report;
  report.ate_m = absoluteTranslationError(*aligned);
  report.per_meter = relativePoseErrors(*aligned, {RelativePoseParams::Unit::kMeters, 1.0});
  report.per_frame = relativePoseErrors(*aligned, {RelativePoseParams::Unit::kFrames, 1.0});
  report.T_reference_estimate = aligned->T_reference_estimate;
  return report;
}

RunReport evaluateRun(const fs::path& run, const Trajectory& reference,
                      const EntityTruths* truths) {
  RunReport report;
  report.run = run.string();
  if (!fs::is_directory(run)) {
    report.trajectory = evaluateTrajectory(reference, readTum(run), run.string());
    return report;
  }
  const fs::path trajectory = run / "trajectory.tum";
  report.trajectory = evaluateTrajectory(reference, readTum(trajectory), trajectory.string());
  report.odometry = evaluateIfPresent(run / "odometry.tum", reference);
  report.keyframes = evaluateIfPresent(run / "keyframes.tum", reference);
  report.loops = evaluateLoopsIfPresent(run, reference);
  if (truths) {
    report.entities =
        evaluateEntityFile(run / "entities.csv", *truths, report.trajectory.T_reference_estimate);
  }
  return report;
}

}  // namespace dynemo
