#include "dynemo/odometry/cell_index.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <vector>

namespace dynemo {
namespace {

TEST(CellIndex, NumbersCellsInTheOrderOfInsertionThroughGrowth) {
  CellIndex index(4);
  std::vector<CellCoordinates> cells;
  for (int x = -12; x < 12; ++x) {
    for (int y = -12; y < 12; ++y) cells.emplace_back(x, y, x * y);
  }
  for (std::size_t i = 0; i < cells.size(); ++i) EXPECT_EQ(index.findOrAdd(cells[i]), i);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    EXPECT_EQ(index.find(cells[i]), i);
    EXPECT_EQ(index.findOrAdd(cells[i]), i);
  }
  EXPECT_EQ(index.size(), cells.size());
  EXPECT_EQ(index.find({100, 0, 0}), CellIndex::kNone);
  index.clear();
  EXPECT_EQ(index.find(cells[0]), CellIndex::kNone);
}

TEST(CellIndex, CellsOfNegativeAndAbsurdCoordinates) {
  EXPECT_EQ(cellOf({-0.1F, 0.1F, 0.6F}, 2.0F), CellCoordinates(-1, 0, 1));
  const float huge = std::numeric_limits<float>::max();
  const CellCoordinates far = cellOf({huge, -huge, 0.0F}, 2.0F);
  EXPECT_EQ(far.x(), 1048575);
  EXPECT_EQ(far.y(), -1048575);
}

}  // namespace
}  // namespace dynemo
