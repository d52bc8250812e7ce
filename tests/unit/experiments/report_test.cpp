#include "dynemo/experiments/report.h"

#include <gtest/gtest.h>

#include "made_up_runs.h"

namespace dynemo::experiments {
namespace {

TEST(Report, IsOnePageWithTablesClaimsFiguresAndWhatIsMissing) {
  ReportInput input;
  input.plan.datasets = {"S-SAMO"};
  input.plan.setups = {"baseline", "full"};
  input.results = {test::madeUp("S-SAMO", 1, "baseline", 0.1),
                   test::madeUp("S-SAMO", 1, "full", 0.04),
                   test::madeUp("S-SAMO", 2, "full", 0.06)};
  input.missing = {"S-SAMO/seed2/keyframe_gicp/baseline: crashed <here>"};
  input.paper = PaperTables::read(std::string(DYNEMO_SOURCE_DIR) + "/share/data/paper");
  input.figures = {{"name", "a caption", "<?xml?><svg>drawing</svg>"}};
  const std::string html = reportHtml(input);
  for (const char* part :
       {"<td>Full</td><td>5.00<small> ±12.71</small> <span class=paper>[9.0]", "a caption",
        "<svg>drawing</svg>", "crashed &lt;here>", "cuts the ATE", "</html>"})
    EXPECT_NE(html.find(part), std::string::npos) << part;
  EXPECT_EQ(html.find("http"), std::string::npos) << "needs no network";
}

}  // namespace
}  // namespace dynemo::experiments
