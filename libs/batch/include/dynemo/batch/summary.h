// One table over all runs of a batch.
#pragma once

#include <string>
#include <vector>

#include "dynemo/batch/run_store.h"

namespace dynemo {

/// A table whose cells are text.
struct Table {
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;
};

/// One row per item, in the order of the list: state, counts of the run, and the figures of
/// dynemo-eval where ground truth lies beside the rawlog (empty cells elsewhere); a note says why a
/// run failed, why it should not be trusted, and what could not be read. The same runs give the
/// same table.
Table summaryTable(const std::vector<WorkItem>& items, const RunStore& store);
/// Wall and CPU time, real-time factor and memory of each finished run.
Table performanceTable(const std::vector<WorkItem>& items, const RunStore& store);

std::string tableCsv(const Table& table);
/// With columns aligned, for people.
std::string tableText(const Table& table);

}  // namespace dynemo
