#include "dynemo/odometry/worker_pool.h"

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

namespace dynemo {

struct WorkerPool::Impl {
  std::mutex mutex;
  std::condition_variable started, finished;
  const std::function<void(std::size_t)>* job = nullptr;
  std::size_t jobs = 0, next = 0, running = 0;
  bool stop = false;
  std::vector<std::thread> threads;

  /// Takes jobs until none is left. Called and left with the lock held.
  void drain(std::unique_lock<std::mutex>& lock) {
    while (next < jobs) {
      const std::size_t mine = next++;
      ++running;
      lock.unlock();
      (*job)(mine);
      lock.lock();
      --running;
    }
  }

  void work() {
    std::unique_lock lock(mutex);
    for (;;) {
      started.wait(lock, [this] { return stop || next < jobs; });
      if (stop) return;
      drain(lock);
      if (running == 0) finished.notify_one();
    }
  }
};

WorkerPool::WorkerPool(int threads) : impl_(std::make_unique<Impl>()) {
  for (int i = 1; i < threads; ++i) impl_->threads.emplace_back([this] { impl_->work(); });
}

WorkerPool::~WorkerPool() {
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->stop = true;
  }
  impl_->started.notify_all();
  for (std::thread& thread : impl_->threads) thread.join();
}

void WorkerPool::run(std::size_t jobs, const std::function<void(std::size_t)>& job) {
  if (impl_->threads.empty() || jobs <= 1) {
    for (std::size_t i = 0; i < jobs; ++i) job(i);
    return;
  }
  std::unique_lock lock(impl_->mutex);
  impl_->job = &job;
  impl_->next = 0;
  impl_->jobs = jobs;
  impl_->started.notify_all();
  impl_->drain(lock);
  impl_->finished.wait(lock, [this] { return impl_->running == 0; });
  impl_->jobs = impl_->next = 0;
}

void WorkerPool::blocks(std::size_t count, std::size_t block,
                        const std::function<void(std::size_t, std::size_t, std::size_t)>& body) {
  run((count + block - 1) / block,
      [&](std::size_t i) { body(i, i * block, std::min(count, (i + 1) * block)); });
}

}  // namespace dynemo
