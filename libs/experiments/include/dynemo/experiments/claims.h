// Whether the runs bear out what the paper claims.
#pragma once

#include <string>
#include <vector>

#include "dynemo/experiments/paper_tables.h"
#include "dynemo/experiments/tables.h"

namespace dynemo::experiments {

enum class Verdict { kBorneOut, kNotBorneOut, kUndecided, kNotRun };
const char* verdictName(Verdict verdict);

struct Claim {
  std::string text;
  std::string odometry;
  Verdict verdict = Verdict::kNotRun;
  std::string figures;  ///< what the verdict rests on
};

/// Each claim for each odometry. A claim compares two setups by the relative change of the ATE, one
/// value per dataset and seed; it is borne out when its 95 % interval (or the single value) lies on
/// the claimed side of zero, not borne out when it lies on the other one, undecided in between.
std::vector<Claim> judgeClaims(const std::vector<RunResult>& results, const PaperTables& paper);

}  // namespace dynemo::experiments
