#include "dynemo/graph/slots.h"

#include <gtest/gtest.h>

#include <memory>

namespace dynemo {
namespace {

using Numbers = Slots<std::shared_ptr<int>>;

Numbers upTo(int n) {
  Numbers slots;
  for (int i = 0; i < n; ++i) slots.push_back(std::make_shared<int>(i));
  return slots;
}

std::vector<int> visited(const Numbers& slots) {
  std::vector<int> all;
  for (const auto& number : slots) all.push_back(*number);
  return all;
}

TEST(Slots, IndicesKeepTheirMeaning) {
  Numbers slots = upTo(200);
  for (std::size_t i = 0; i < 200; ++i)
    if (i % 50 != 7) slots.remove(i);
  slots.push_back(std::make_shared<int>(200));
  EXPECT_EQ(slots.size(), 201u);
  for (std::size_t i = 0; i <= 200; ++i) {
    if (i % 50 == 7 || i == 200) {
      ASSERT_TRUE(slots[i]) << i;
      EXPECT_EQ(*slots[i], static_cast<int>(i));
    } else {
      EXPECT_FALSE(slots[i]) << i;
    }
  }
  EXPECT_THROW(slots.at(201), std::out_of_range);
  EXPECT_EQ(visited(slots), (std::vector<int>{7, 57, 107, 157, 200}));
}

TEST(Slots, LoopsOverNothing) {
  EXPECT_EQ(visited(Numbers()), std::vector<int>());
  Numbers slots = upTo(70);
  for (std::size_t i = 0; i < 70; ++i) slots.remove(i);
  EXPECT_EQ(visited(slots), std::vector<int>());
  EXPECT_EQ(slots.size(), 70u);
}

TEST(Slots, SkippedIndicesAreRemovedOnes) {
  Numbers slots;
  for (int i = 0; i < 100; ++i)
    i % 40 == 3 ? slots.push_back(std::make_shared<int>(i)) : slots.skip();
  EXPECT_EQ(visited(slots), (std::vector<int>{3, 43, 83}));
  EXPECT_FALSE(slots[99]);
}

TEST(Slots, CopiesStandAlone) {
  Numbers slots = upTo(40);
  const Numbers copy = slots;
  for (std::size_t i = 0; i < 40; ++i) slots.remove(i);
  EXPECT_EQ(visited(copy), visited(upTo(40)));
}

/// Counts those that exist.
struct Counted {
  static int alive;
  bool is_there = false;
  explicit Counted(bool there = false) : is_there(there) { ++alive; }
  Counted(const Counted& other) : is_there(other.is_there) { ++alive; }
  Counted& operator=(const Counted&) = default;
  ~Counted() { --alive; }
  explicit operator bool() const { return is_there; }
};
int Counted::alive = 0;

TEST(Slots, WhatIsGoneTakesNoMemory) {
  Slots<Counted> slots;
  for (int i = 0; i < 10'000; ++i) {
    slots.push_back(Counted(true));
    if (i >= 20) slots.remove(static_cast<std::size_t>(i) - 20);
  }
  EXPECT_EQ(std::distance(slots.begin(), slots.end()), 20);
  EXPECT_LT(Counted::alive, 100);
}

}  // namespace
}  // namespace dynemo
