#include "dynemo/experiments/csv_table.h"

#include <gtest/gtest.h>

#include <fstream>

#include "dynemo/core/error.h"

namespace dynemo::experiments {
namespace {

std::filesystem::path write(const std::string& text) {
  const auto file = std::filesystem::path(testing::TempDir()) / "table.csv";
  std::ofstream(file) << text;
  return file;
}

TEST(CsvTable, ReadsCellsByColumn) {
  const CsvTable table = CsvTable::read(write("a,b,c\n1,x y,\n-2.5,z,3\n"));
  ASSERT_EQ(table.rows(), 2u);
  EXPECT_EQ(table.number(1, "a"), -2.5);
  EXPECT_EQ(table.text(0, "b"), "x y");
  EXPECT_EQ(table.text(0, "c"), "");
}

TEST(CsvTable, RefusesWhatItCannotUse) {
  EXPECT_THROW(CsvTable::read("/nowhere.csv"), DataError);
  EXPECT_THROW(CsvTable::read(write("a,b\n1\n")), DataError);
  const CsvTable table = CsvTable::read(write("a\nx\n"));
  EXPECT_THROW(table.number(0, "a"), DataError);
  EXPECT_THROW(table.text(0, "b"), DataError);
}

}  // namespace
}  // namespace dynemo::experiments
