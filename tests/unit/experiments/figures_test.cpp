#include "dynemo/experiments/figures.h"

#include <gtest/gtest.h>

#include "made_up_runs.h"

namespace dynemo::experiments {
namespace {

namespace fs = std::filesystem;

TEST(Figures, AreDrawnByGnuplot) {
  const fs::path folder = fs::path(testing::TempDir()) / "figures";
  const auto figures =
      drawFigures({test::madeUp("S-SAMO", 1, "full", 0.05), test::madeUp("S-SAMO", 1, "fcs", 0.06)},
                  {}, folder);
  ASSERT_EQ(figures.size(), 6u) << "optimisation time, map, and two errors with and without timer";
  for (const Figure& figure : figures) {
    SCOPED_TRACE(figure.name);
    EXPECT_NE(figure.svg.find("<svg"), std::string::npos);
    EXPECT_NE(figure.svg.find("</svg>"), std::string::npos);
    EXPECT_FALSE(figure.caption.empty());
  }
  EXPECT_NE(figures[1].svg.find("truth"), std::string::npos);
  EXPECT_NE(figures[1].svg.find("Full"), std::string::npos);
  for (const char* curve : {">objects, truth<", ">objects<", ">agents, truth<", ">agents<"})
    EXPECT_NE(figures[1].svg.find(curve), std::string::npos) << curve;
}

}  // namespace
}  // namespace dynemo::experiments
