// Memory must not grow with the length of a rawlog.
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "dynemo/ingest/rawlog_source.h"
#include "generated_rawlog.h"

namespace dynemo {
namespace {

using namespace test;  // NOLINT

double residentMemory_MB() {
  std::ifstream statm("/proc/self/statm");
  double pages = 0, resident = 0;
  statm >> pages >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

TEST(Memory, DoesNotGrowWithTheLog) {
  const TemporaryFolder folder;
  constexpr double kCloud_MB = 5000 * 12e-6;
  writeLog(folder / "log.rawlog",
           {.duration_s = 120.0, .odometry_period_s = 0.02, .points = 5000, .compressed = true});
  const auto source = makeRawlogSource({}, folder / "log.rawlog");
  std::size_t frames = 0;
  double early_MB = 0, peak_MB = 0;
  while (source->next()) {
    ++frames;
    if (frames == 200) early_MB = residentMemory_MB();
    if (frames > 200) peak_MB = std::max(peak_MB, residentMemory_MB());
  }
  EXPECT_EQ(frames, 1201U);
  const double all_clouds_MB = 1000 * kCloud_MB;
  EXPECT_LT(peak_MB - early_MB, 0.2 * all_clouds_MB);
}

}  // namespace
}  // namespace dynemo
