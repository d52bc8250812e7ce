#include "dynemo/core/registry.h"

#include <gtest/gtest.h>

namespace dynemo::test {
namespace {

struct Shape {
  virtual ~Shape() = default;
  virtual double area() const = 0;
};
struct Square : Shape {
  explicit Square(double side) : side_(side) {}
  double area() const override { return side_ * side_; }
  double side_;
};

Registry<Shape, double> shapes() {
  Registry<Shape, double> registry("shape");
  registry.add("square", [](double side) { return std::make_unique<Square>(side); });
  registry.add("double_square", [](double side) { return std::make_unique<Square>(2 * side); });
  return registry;
}

TEST(Registry, MakesWhatIsNamed) {
  EXPECT_EQ(shapes().make("square", 3.0)->area(), 9.0);
  EXPECT_EQ(shapes().make("double_square", 3.0)->area(), 36.0);
}

TEST(Registry, ListsItsNamesSorted) {
  EXPECT_EQ(shapes().names(), (std::vector<std::string>{"double_square", "square"}));
  EXPECT_TRUE(shapes().contains("square"));
  EXPECT_FALSE(shapes().contains("circle"));
}

TEST(Registry, UnknownNameListsTheKnownOnes) {
  try {
    shapes().make("circle", 1.0);
    FAIL();
  } catch (const ConfigError& e) {
    for (const char* part : {"shape", "circle", "square", "double_square"}) {
      EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
    }
  }
}

}  // namespace
}  // namespace dynemo::test
