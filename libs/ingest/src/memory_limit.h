#pragma once

#include <cstddef>

namespace dynemo {

/// While it lives, the address space of the process cannot grow by more than `bytes`, so that a
/// corrupt length in a file ends in std::bad_alloc and not in gigabytes of zeros. The limit is a
/// property of the process (setrlimit); other threads share the allowance meanwhile. Without effect
/// under AddressSanitizer, which reserves terabytes.
class MemoryLimit {
 public:
  explicit MemoryLimit(std::size_t bytes);
  ~MemoryLimit();
  MemoryLimit(const MemoryLimit&) = delete;
  MemoryLimit& operator=(const MemoryLimit&) = delete;

 private:
  unsigned long long previous_ = 0;
  bool active_ = false;
};

}  // namespace dynemo
