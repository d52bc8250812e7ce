#include "dynemo/ingest/time_order.h"

#include <gtest/gtest.h>

#include "generated_rawlog.h"

namespace dynemo {
namespace {

using test::at;

class Ordering : public ::testing::Test {
 protected:
  SyncParams sync_;
  ClockParams clock_;
  WarningCounter warnings_;

  /// What comes out, in seconds, for these stamps going in.
  std::vector<double> order(const std::vector<double>& stamps) {
    TimeOrder order(sync_, clock_, warnings_);
    std::vector<double> out;
    const auto drain = [&] {
      while (const auto item = order.pop()) out.push_back(secondsBetween(at(0), item->stamp));
    };
    for (const double s : stamps) {
      TimedItem item;
      item.stamp = at(s);
      order.push(item);
      drain();
    }
    order.finish();
    drain();
    return out;
  }
  static std::vector<double> ramp(double from, int n) {
    std::vector<double> stamps;
    for (int i = 0; i < n; ++i) stamps.push_back(from + 0.1 * i);
    return stamps;
  }
  std::uint64_t count(const std::string& part) {
    IngestReport report;
    report.warnings = warnings_.counts();
    return test::warningCount(report, part);
  }
};

std::vector<double> operator+(std::vector<double> a, const std::vector<double>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

void expectEqual(const std::vector<double>& actual, const std::vector<double>& expected) {
  ASSERT_EQ(actual.size(), expected.size());
  for (std::size_t i = 0; i < actual.size(); ++i) EXPECT_NEAR(actual[i], expected[i], 1e-9) << i;
}

TEST_F(Ordering, SortsWithinTheWindow) {
  expectEqual(order({0.0, 0.3, 0.1, 0.2, 0.6, 0.5, 0.4}), {0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6});
  EXPECT_TRUE(warnings_.counts().empty());
}

TEST_F(Ordering, HoldsBackOnlyTheWindow) {
  TimeOrder order(sync_, clock_, warnings_);
  std::size_t most = 0, inside = 0;
  for (const double s : ramp(0, 1000)) {
    TimedItem item;
    item.stamp = at(s);
    order.push(item);
    ++inside;
    while (order.pop()) --inside;
    most = std::max(most, inside);
  }
  EXPECT_LE(most, 6U);
}

TEST_F(Ordering, LateOnesAreDropped) {
  expectEqual(order(ramp(0, 20) + std::vector<double>{0.35} + ramp(2.0, 5)),
              ramp(0, 20) + ramp(2.0, 5));
  EXPECT_EQ(count("runs backwards"), 1U);
}

TEST_F(Ordering, FirstStampFarAheadDoesNotTakeTheLogWithIt) {
  expectEqual(order(std::vector<double>{1e8} + ramp(0, 50)), ramp(0, 50));
  EXPECT_EQ(count("far from those that follow"), 1U);
}

TEST_F(Ordering, SetBackClockIsShifted) {
  const auto out = order(ramp(1000, 50) + ramp(0, 50));
  ASSERT_EQ(out.size(), 100U);
  EXPECT_NEAR(out[50] - out[49], sync_.sort_window_s, 1e-9);
  for (std::size_t i = 1; i < out.size(); ++i) EXPECT_LT(out[i - 1], out[i]);
  EXPECT_EQ(count("clock set back"), 1U);
}

TEST_F(Ordering, TwoResetsInARow) {
  const auto out = order(ramp(1000, 50) + ramp(0, 50) + ramp(-900, 50));
  ASSERT_EQ(out.size(), 150U);
  for (std::size_t i = 1; i < out.size(); ++i) EXPECT_LT(out[i - 1], out[i]);
  EXPECT_EQ(count("clock set back"), 2U);
}

TEST_F(Ordering, FewStampsBackAtTheEndAreNotBelieved) {
  expectEqual(order(ramp(1000, 50) + ramp(0, 5)), ramp(1000, 50));
  EXPECT_EQ(count("runs backwards"), 5U);
}

TEST_F(Ordering, FewStampsAheadAtTheEndAreBelieved) {
  expectEqual(order(ramp(0, 50) + ramp(500, 5)), ramp(0, 50) + ramp(500, 5));
}

TEST_F(Ordering, SparseLogsPass) {
  std::vector<double> sparse;
  for (int i = 0; i < 37; ++i) sparse.push_back(60.0 * i);
  expectEqual(order(sparse), sparse);
}

TEST_F(Ordering, FrozenClockDoesNotFillTheMemory) {
  TimeOrder order(sync_, clock_, warnings_);
  std::size_t inside = 0;
  for (int i = 0; i < 5000; ++i) {
    TimedItem item;
    item.stamp = at(1);
    item.role = SensorRole::kScan;
    order.push(item);
    ++inside;
    while (order.pop()) --inside;
  }
  EXPECT_LE(inside, 300U);
}

}  // namespace
}  // namespace dynemo
