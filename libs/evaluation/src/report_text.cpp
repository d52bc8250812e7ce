#include <cmath>
#include <cstdio>
#include <numbers>

#include "dynemo/evaluation/run_report.h"

namespace dynemo {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;
constexpr double kCentimeters = 100.0;

template <class... Args>
std::string formatted(const char* format, Args... args) {
  char buffer[512];
  std::snprintf(buffer, sizeof(buffer), format, args...);
  return buffer;
}

std::string cell(double value, int decimals) {
  if (!std::isfinite(value)) return formatted(" %10s", "-");
  return formatted(" %10.*f", decimals, value);
}

std::string statisticsHeader(const std::string& title) {
  return formatted("\n%-34s %10s %10s %10s %10s %10s %10s %7s\n", title.c_str(), "rmse", "mean",
                   "median", "std", "min", "max", "count");
}

std::string statisticsRow(const std::string& name, const Statistics& s, double scale = 1.0,
                          int decimals = 6) {
  std::string text = formatted("  %-32.32s", name.c_str());
  for (const double value : {s.rmse, s.mean, s.median, s.std, s.min, s.max}) {
    text += cell(scale * value, decimals);
  }
  return text + formatted(" %7zu\n", s.count);
}

std::string poseRows(const std::string& name, const PoseErrorStatistics& s) {
  if (s.translation_m.count == 0) return "";
  return statisticsRow(name + " [cm]", s.translation_m, kCentimeters, 2) +
         statisticsRow(name + " [deg]", s.rotation_rad, kDegrees, 2);
}

std::string relativeRows(const std::string& name, const RelativePoseErrors& s) {
  return statisticsRow(name + " [m]", s.translation_m) +
         statisticsRow(name + " [deg]", s.rotation_rad, kDegrees);
}

std::string trajectoryText(const RunReport& report) {
  std::string text = statisticsHeader("Trajectory (SE(3)-aligned)");
  text += statisticsRow("ATE [m]", report.trajectory.ate_m);
  if (report.keyframes) text += statisticsRow("ATE of keyframes [m]", report.keyframes->ate_m);
  if (report.odometry) text += statisticsRow("ATE of odometry [m]", report.odometry->ate_m);
  text += relativeRows("RPE over 1 m", report.trajectory.per_meter);
  text += relativeRows("RPE per frame", report.trajectory.per_frame);
  if (report.odometry) {
    text += relativeRows("RPE of odometry over 1 m", report.odometry->per_meter);
  }
  return text;
}

std::string loopText(const LoopReport& loops) {
  std::string text = formatted("\n%-34s %10s %10s %10s\n", "Loop closures", "share", "of", "all");
  const auto row = [&](const char* name, double value, std::size_t part, std::size_t whole) {
    text += formatted("  %-32s", name) + cell(value, 3) + formatted(" %10zu %10zu\n", part, whole);
  };
  row("precision: right", loops.precision(), loops.right, loops.closures);
  row("recall: closable keyframes", loops.recall(), loops.recalled, loops.closable);
  if (loops.removed > 0) {
    text +=
        formatted("  %zu taken out again, %zu of them right\n", loops.removed, loops.removed_right);
  }
  if (loops.without_truth > 0)
    text += formatted("  %zu closures are not covered by the reference\n", loops.without_truth);
  if (loops.closures == 0) return text;
  return text + statisticsHeader("Errors of loop closures") +
         poseRows("relative pose", loops.errors);
}

std::string entityText(const EntityReport& report) {
  std::string text = statisticsHeader("Entities (aligned as trajectory)");
  const EntityErrors& errors = report.errors;
  text += poseRows("objects, first", firstErrors(errors, SemanticClass::kObject));
  text += poseRows("objects, final", finalErrors(errors, SemanticClass::kObject));
  text += poseRows("object placements, last", placementErrors(errors));
  text += poseRows("object motion (ME)", report.object_motions.me);
  text += poseRows("object motion (RME)", report.object_motions.rme);
  text += poseRows("agents, first", firstErrors(errors, SemanticClass::kAgent));
  text += poseRows("agents, final", finalErrors(errors, SemanticClass::kAgent));
  text += poseRows("agent motion (ME)", report.agent_motions.me);
  text += poseRows("agent motion (RME)", report.agent_motions.rme);
  if (errors.without_truth > 0) {
    text +=
        formatted("  %zu observations are not covered by the reference\n", errors.without_truth);
  }
  return text;
}

std::string placementsText(const EntityErrors& errors) {
  if (errors.placements.empty()) return "";
  std::string text = formatted("\n%-34s %10s %10s %10s %10s %7s\n", "Object placements", "last cm",
                               "last deg", "median cm", "median deg", "nodes");
  for (const PlacementError& p : errors.placements) {
    const EntitySummary& entity = errors.entities.at(p.entity);
    const std::string name = std::to_string(p.entity.value) + " " + entity.name + ", place " +
                             std::to_string(p.placement + 1);
    text += formatted("  %-32.32s", name.c_str());
    text += cell(kCentimeters * p.last.translation_m, 2) + cell(kDegrees * p.last.rotation_rad, 2);
    text +=
        cell(kCentimeters * p.median.translation_m, 2) + cell(kDegrees * p.median.rotation_rad, 2);
    text += formatted(" %7zu\n", p.nodes);
  }
  return text;
}

std::string perEntityText(const EntityErrors& errors) {
  std::string text = formatted("\n%-34s %10s %10s %10s %10s %7s\n", "Each entity (median)",
                               "first cm", "first deg", "final cm", "final deg", "nodes");
  for (const auto& [id, e] : errors.entities) {
    const std::string name = std::to_string(id.value) + " " + e.name;
    text += formatted("  %-32.32s", name.c_str());
    text += cell(kCentimeters * e.first.translation_m.median, 2);
    text += cell(kDegrees * e.first.rotation_rad.median, 2);
    text += cell(kCentimeters * e.final.translation_m.median, 2);
    text += cell(kDegrees * e.final.rotation_rad.median, 2);
    text += formatted(" %7zu\n", e.final.translation_m.count);
  }
  return text;
}

std::string countsRow(const char* name, const DetectionCounts& c) {
  return formatted("  %-32s %10.3f %10.3f %10.3f %10zu %10zu %10zu\n", name, c.precision(),
                   c.recall(), c.f1(), c.true_positives, c.false_positives, c.false_negatives);
}

std::string changesText(const ChangeReport& changes) {
  std::string text = formatted("\n%-34s %10s %10s %10s %10s %10s %10s\n", "Changes", "precision",
                               "recall", "F1", "true pos", "false pos", "false neg");
  text += countsRow("moved, per object", changes.by_object);
  text += countsRow("moved, per observation", changes.by_observation);
  text += countsRow("objects at the end", changes.objects_at_end);
  return text;
}

std::string neesRow(const char* name, const NeesSummary& s) {
  if (s.count == 0) return "";
  return formatted("  %-32s mean %.2f (expected 6), %.1f %% inside the %.0f %% bound, %zu nodes\n",
                   name, s.mean, 100.0 * s.share_inside, 100.0 * s.probability, s.count);
}

std::string consistencyText(const EntityErrors& errors) {
  const std::string rows = neesRow("objects", neesSummary(errors, SemanticClass::kObject)) +
                           neesRow("agents", neesSummary(errors, SemanticClass::kAgent));
  return rows.empty() ? "" : "\nConsistency (NEES)\n" + rows;
}

}  // namespace

std::string reportText(const RunReport& report) {
  std::string text = report.run + '\n' + trajectoryText(report);
  if (report.loops) text += loopText(*report.loops);
  if (report.entities) {
    text += entityText(*report.entities) + placementsText(report.entities->errors) +
            perEntityText(report.entities->errors) + changesText(report.entities->changes) +
            consistencyText(report.entities->errors);
  }
  return text;
}

}  // namespace dynemo
