#include "dynemo/experiments/tables.h"

#include <gtest/gtest.h>

#include "made_up_runs.h"

namespace dynemo::experiments {
namespace {

using test::madeUp;

PaperTables paper() {
  return PaperTables::read(std::string(DYNEMO_SOURCE_DIR) + "/share/data/paper");
}

TEST(PaperTables, HoldThePapersFigures) {
  const PaperTables tables = paper();
  const PaperRow* row = tables.find("S-SAMO", "full");
  ASSERT_NE(row, nullptr);
  EXPECT_EQ(row->ate_rmse_cm, 9.045);
  EXPECT_EQ(row->loop_closures, 6);
  EXPECT_EQ(tables.find("S-SAMO", "another"), nullptr);
  EXPECT_EQ(tables.entities().size(), 28u);
  const auto cut = tables.meanCut({"S-SASO", "S-SAMO", "S-MASO", "S-MAMO", "S-MASO2", "S-MASO3",
                                   "R-SARO", "R-SAMO", "R-MASO", "R-MAMO"});
  ASSERT_TRUE(cut);
  EXPECT_NEAR(*cut, 0.492, 0.001);
}

TEST(Cells, AverageOverSeeds) {
  const auto cells = cellsOf({madeUp("S-SAMO", 1, "full", 0.04), madeUp("S-SAMO", 1, "fcs", 0.07),
                              madeUp("S-SAMO", 2, "full", 0.06)});
  ASSERT_EQ(cells.size(), 2u);
  const Cell* full = findCell(cells, "S-SAMO", "keyframe_gicp", "full");
  ASSERT_NE(full, nullptr);
  EXPECT_NEAR(full->ate_rmse_cm.mean, 5.0, 1e-12);
  EXPECT_EQ(full->ate_rmse_cm.count, 2u);
  EXPECT_NEAR(full->entity_first_cm.mean, 6.0, 1e-12) << "objects only";
  EXPECT_NEAR(full->entity_last_cm.mean, 2.0, 1e-12);
  EXPECT_EQ(full->loop_closures.count, 0u);
  EXPECT_EQ(findCell(cells, "S-SAMO", "local_map", "full"), nullptr);
}

TEST(TablesCsv, HasOurFiguresAndThePapers) {
  const std::string csv = tablesCsv(cellsOf({madeUp("S-SAMO", 1, "full", 0.04)}), paper());
  EXPECT_NE(csv.find("\nS-SAMO,keyframe_gicp,full,1,4,0,2,0,8,0,,,3,0,2.5,0,6,"), std::string::npos)
      << csv;
  EXPECT_NE(csv.find(",9.045,7.197,6,78\n"), std::string::npos) << csv;
}

}  // namespace
}  // namespace dynemo::experiments
