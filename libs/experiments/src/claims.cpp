#include "dynemo/experiments/claims.h"

#include <algorithm>
#include <cstdio>
#include <functional>

namespace dynemo::experiments {
namespace {

/// "setup a has a lower ATE than setup b on these datasets".
struct Comparison {
  const char* text;
  const char* better;
  const char* worse;
  std::function<bool(const std::string& dataset)> applies;
};

bool everywhere(const std::string&) { return true; }
/// Nothing moves by itself or is moved.
bool isStatic(const std::string& dataset) { return dataset == "S-SASO"; }
bool isDynamic(const std::string& dataset) { return !isStatic(dataset); }
bool isShort(const std::string& dataset) { return dataset == "S-MASO2"; }
bool isSimulated(const std::string& dataset) { return dataset.rfind("S-", 0) == 0; }

const std::vector<Comparison>& comparisons() {
  static const std::vector<Comparison> list{
      {"Keyframe–entity constraints and dynamic keyframes help", "only-kf-e", "baseline",
       everywhere},
      {"Intra-entity constraints help further", "intra-e", "only-kf-e", everywhere},
      {"Floor–entity constraints help further", "f-e", "only-kf-e", everywhere},
      {"The full constraint set is better than the baseline", "fcs", "baseline", everywhere},
      {"Always removing entity points hurts in static scenes", "mb-epcr", "always-epcr", isStatic},
      {"Removing the points of moved entities helps in dynamic scenes", "mb-epcr", "fcs",
       isDynamic},
      {"The timer helps in simulation", "full", "mb-epcr", isSimulated},
      {"The timer helps short runs", "full", "mb-epcr", isShort},
      {"The full system cuts the ATE of the baseline", "full", "baseline", everywhere}};
  return list;
}

/// 1 − better / worse for each dataset and seed that has both.
std::vector<double> cuts(const std::vector<RunResult>& results, const Comparison& c,
                         const std::string& odometry) {
  std::vector<double> values;
  for (const RunResult& a : results) {
    if (a.key.odometry != odometry || a.key.setup != c.better || !c.applies(a.key.dataset))
      continue;
    for (const RunResult& b : results) {
      const RunKey other{a.key.dataset, a.key.seed, odometry, c.worse};
      if (b.key == other && b.ate_rmse_m > 0) values.push_back(1.0 - a.ate_rmse_m / b.ate_rmse_m);
    }
  }
  return values;
}

Verdict judge(const MeanInterval& cut) {
  if (cut.count == 0) return Verdict::kNotRun;
  if (cut.mean - cut.half_width > 0.0) return Verdict::kBorneOut;
  if (cut.mean + cut.half_width < 0.0) return Verdict::kNotBorneOut;
  return Verdict::kUndecided;
}

std::string figures(const MeanInterval& cut) {
  if (cut.count == 0) return "no runs";
  char text[128];
  std::snprintf(text, sizeof(text), "ATE cut by %.1f ± %.1f %% (%zu pairs of runs)", 100 * cut.mean,
                100 * cut.half_width, cut.count);
  return text;
}

std::vector<std::string> datasetsOf(const std::vector<RunResult>& results) {
  std::vector<std::string> names;
  for (const RunResult& r : results)
    if (std::find(names.begin(), names.end(), r.key.dataset) == names.end())
      names.push_back(r.key.dataset);
  return names;
}

std::vector<std::string> odometriesOf(const std::vector<RunResult>& results) {
  std::vector<std::string> names;
  for (const RunResult& r : results)
    if (std::find(names.begin(), names.end(), r.key.odometry) == names.end())
      names.push_back(r.key.odometry);
  return names;
}

}  // namespace

const char* verdictName(Verdict verdict) {
  switch (verdict) {
    case Verdict::kBorneOut:
      return "borne out";
    case Verdict::kNotBorneOut:
      return "not borne out";
    case Verdict::kUndecided:
      return "undecided";
    case Verdict::kNotRun:
      return "not run";
  }
  return "";
}

std::vector<Claim> judgeClaims(const std::vector<RunResult>& results, const PaperTables& paper) {
  std::vector<Claim> claims;
  for (const std::string& odometry : odometriesOf(results)) {
    for (const Comparison& c : comparisons()) {
      const MeanInterval cut = meanInterval(cuts(results, c, odometry));
      claims.push_back({c.text, odometry, judge(cut), figures(cut)});
    }
    if (const auto cut = paper.meanCut(datasetsOf(results))) {
      char text[96];
      std::snprintf(text, sizeof(text), "; the paper's on these datasets: %.1f %%", 100 * *cut);
      claims.back().figures += text;
    }
  }
  return claims;
}

}  // namespace dynemo::experiments
