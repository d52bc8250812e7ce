// The study as one page of HTML that needs no network.
#pragma once

#include <string>
#include <vector>

#include "dynemo/experiments/claims.h"
#include "dynemo/experiments/figures.h"
#include "dynemo/experiments/tables.h"

namespace dynemo::experiments {

struct ReportInput {
  ExperimentPlan plan;
  std::vector<RunResult> results;
  std::vector<std::string> missing;  ///< runs of the plan without a result, and why
  PaperTables paper;
  std::vector<Figure> figures;
};

std::string reportHtml(const ReportInput& input);

}  // namespace dynemo::experiments
