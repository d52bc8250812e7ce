#include "dynemo/odometry/worker_pool.h"

#include <gtest/gtest.h>

#include <vector>

namespace dynemo {
namespace {

TEST(WorkerPool, RunsEveryJobOnceWithAnyNumberOfThreads) {
  for (const int threads : {1, 2, 5}) {
    WorkerPool pool(threads);
    for (int repeat = 0; repeat < 50; ++repeat) {
      std::vector<int> done(37, 0);
      pool.run(done.size(), [&](std::size_t i) { ++done[i]; });
      EXPECT_EQ(done, std::vector<int>(37, 1)) << threads << " threads";
    }
    pool.run(0, [](std::size_t) { FAIL() << "there is no job"; });
  }
}

TEST(WorkerPool, BlocksCoverTheRangeWithoutOverlap) {
  WorkerPool pool(2);
  std::vector<int> covered(1000, 0);
  std::vector<std::size_t> begins(4, 0);
  pool.blocks(covered.size(), 256, [&](std::size_t block, std::size_t begin, std::size_t end) {
    begins[block] = begin;
    for (std::size_t i = begin; i < end; ++i) ++covered[i];
  });
  EXPECT_EQ(covered, std::vector<int>(1000, 1));
  EXPECT_EQ(begins, (std::vector<std::size_t>{0, 256, 512, 768}));
}

}  // namespace
}  // namespace dynemo
