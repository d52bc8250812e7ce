#include "dynemo/core/time.h"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

namespace dynemo::test {
namespace {

TEST(Stamp, ParsesEveryNanosecond) {
  EXPECT_EQ(Stamp::parse("1700000030.123456789").ns, 1'700'000'030'123'456'789);
  EXPECT_EQ(Stamp::parse("1700000030.1").ns, 1'700'000'030'100'000'000);
  EXPECT_EQ(Stamp::parse("1700000030").ns, 1'700'000'030'000'000'000);
  EXPECT_EQ(Stamp::parse(".5").ns, 500'000'000);
  EXPECT_EQ(Stamp::parse("5.").ns, 5'000'000'000);
  EXPECT_EQ(Stamp::parse("+2.5").ns, 2'500'000'000);
  EXPECT_EQ(Stamp::parse("-2.5").ns, -2'500'000'000);
  EXPECT_EQ(Stamp::parse("0.0000000019").ns, 1) << "digits beyond the ninth are cut";
}

TEST(Stamp, ParsesExponents) {
  EXPECT_EQ(Stamp::parse("1.5e3").ns, 1'500'000'000'000);
  EXPECT_EQ(Stamp::parse("1.5E-3").ns, 1'500'000);
}

TEST(Stamp, RefusesWhatIsNoTime) {
  for (const char* text : {"", ".", "-", "+", "abc", "1.2.3", "1 ", " 1", "1s", "0x10", "nan",
                           "inf", "1e", "1e99", "99999999999", "1,5", "--1", "e5"}) {
    EXPECT_THROW(Stamp::parse(text), std::invalid_argument) << "'" << text << "'";
  }
}

TEST(Stamp, TextReadsBackExactly) {
  for (const std::int64_t ns : {0L, 1L, -1L, 999'999'999L, -999'999'999L, -1'000'000'000L,
                                -1'000'000'001L, -1'500'000'000L, 1'700'000'030'123'456'789L}) {
    EXPECT_EQ(Stamp::parse(Stamp{ns}.text()).ns, ns) << Stamp{ns}.text();
  }
  EXPECT_EQ(Stamp{1'700'000'030'000'000'007}.text(), "1700000030.000000007");
  EXPECT_EQ(Stamp{-1'500'000'000}.text(), "-1.500000000");
}

TEST(Stamp, FromSecondsRoundsToNanoseconds) {
  EXPECT_EQ(Stamp::fromSeconds(1.5).ns, 1'500'000'000);
  EXPECT_EQ(Stamp::fromSeconds(-0.25).ns, -250'000'000);
  EXPECT_THROW(Stamp::fromSeconds(std::numeric_limits<double>::quiet_NaN()), std::invalid_argument);
  EXPECT_THROW(Stamp::fromSeconds(1e300), std::invalid_argument);
}

TEST(Stamp, DifferencesAreExact) {
  const Stamp a{1'700'000'030'000'000'001}, b{1'700'000'030'000'000'000};
  EXPECT_EQ(secondsBetween(b, a), 1e-9);
  EXPECT_EQ(secondsBetween(a, b), -1e-9);
  EXPECT_LT(b, a);
}

}  // namespace
}  // namespace dynemo::test
