// Threads that share out independent jobs.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace dynemo {

/// Runs job(0) … job(n − 1) on the calling thread and threads − 1 others. Which thread runs a job
/// is left open, so jobs write to places of their own; whoever cuts work into jobs does so without
/// regard to the number of threads, and adds partial sums in the order of the jobs. Jobs must not
/// throw.
class WorkerPool {
 public:
  explicit WorkerPool(int threads);
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// Returns when all jobs are done.
  void run(std::size_t jobs, const std::function<void(std::size_t)>& job);

  /// Cuts [0, count) into blocks of `block` (the last one shorter) and calls body(block index,
  /// begin, end).
  void blocks(std::size_t count, std::size_t block,
              const std::function<void(std::size_t, std::size_t, std::size_t)>& body);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace dynemo
