#include "dynemo/loops/loop_record.h"

#include <cstdio>

namespace dynemo {

const char* loopDecisionName(LoopDecision decision) {
  switch (decision) {
    case LoopDecision::kAccepted:
      return "accepted";
    case LoopDecision::kRejected:
      return "rejected";
    case LoopDecision::kRemoved:
      return "removed";
  }
  return "";
}

namespace {

constexpr const char* kPoseColumns[] = {"x", "y", "z", "qx", "qy", "qz", "qw"};

template <class... Args>
std::string formatted(const char* format, Args... args) {
  char buffer[256];
  std::snprintf(buffer, sizeof(buffer), format, args...);
  return buffer;
}

std::string poseColumns(const char* prefix) {
  std::string text;
  for (const char* column : kPoseColumns) text += std::string(",") + prefix + column;
  return text;
}

std::string poseCells(const Pose3& T) {
  const auto q = T.quaternion();
  return formatted(",%.6f,%.6f,%.6f,%.9f,%.9f,%.9f,%.9f", T.t.x(), T.t.y(), T.t.z(), q.x(), q.y(),
                   q.z(), q.w());
}

/// "3: moved 0.42 m 0.01 rad, 120 + 96 points; 101: agent, …". Entities that stay are left out.
std::string removedText(const std::vector<EntityDecision>& entities) {
  std::string text;
  for (const EntityDecision& entity : entities) {
    if (!entity.removed) continue;
    text += formatted("%s%lld: %s: %zu + %zu", text.empty() ? "" : "; ",
                      static_cast<long long>(entity.entity.value), entity.reason.c_str(),
                      entity.points_earlier, entity.points_later);
  }
  return text;
}

std::string matchCells(const std::optional<ScanMatch>& match) {
  if (!match) return std::string(5 + std::size(kPoseColumns), ',');
  return formatted(",%.4f,%.4f,%.5f,%.4g,%d", match->inlier_ratio, match->overlap,
                   match->residual_rms_m, match->min_eigenvalue, match->iterations) +
         poseCells(match->T_target_source);
}

/// As a CSV field (RFC 4180).
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

}  // namespace

std::string loopRecordHeader() {
  return "timestamp,decision,reason,edge_id,earlier_id,later_id,earlier_timestamp,later_timestamp,"
         "origin,distance_m,path_m,points_earlier,points_later,removed_earlier,removed_later,"
         "removed_entities,seed_origin" +
         poseColumns("seed_") +
         ",inlier_ratio_seed,inlier_ratio,overlap,residual_rms_m,min_eigenvalue,iterations" +
         poseColumns("") + ",graph_distance";
}

std::string loopRecordRow(const LoopRecord& r) {
  std::string row = r.decided.text() + "," + loopDecisionName(r.decision) + "," + quoted(r.reason) +
                    "," + (r.edge ? std::to_string(r.edge->value) : "");
  row += "," + std::to_string(r.earlier.value) + "," + std::to_string(r.later.value) + "," +
         r.earlier_stamp.text() + "," + r.later_stamp.text() + "," +
         loopOriginName(r.candidate.origin) +
         formatted(",%.4f,%.4f,%zu,%zu,%zu,%zu,", r.candidate.distance_m, r.candidate.path_m,
                   r.scan_points_earlier, r.scan_points_later, r.removed_earlier,
                   r.removed_later);
  row += quoted(removedText(r.entities)) +
         (r.seed_origin == SeedOrigin::kGraph ? ",graph" : ",entities") + poseCells(r.seed);
  row += "," + (r.seed_inlier_ratio ? formatted("%.4f", *r.seed_inlier_ratio) : "") +
         matchCells(r.match) + ",";
  if (r.graph_distance) row += formatted("%.4g", *r.graph_distance);
  return row;
}

}  // namespace dynemo
