#include "memory_limit.h"

#include <sys/resource.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <new>

// MRPT's matrices and point maps allocate through this function of mrpt-core and write to the
// result unchecked: a null pointer there is a crash. This definition takes precedence over the
// library's and differs from it only in that it throws. The memory is released with std::free, as
// before.
namespace mrpt {
void* aligned_malloc(std::size_t size, std::size_t alignment);
void* aligned_malloc(std::size_t size, std::size_t alignment) {
  void* memory = nullptr;
  if (posix_memalign(&memory, alignment, size) != 0) throw std::bad_alloc();
  return memory;
}
}  // namespace mrpt

namespace dynemo {
namespace {

#if defined(__SANITIZE_ADDRESS__)
constexpr bool kUnderAddressSanitizer = true;
#else
constexpr bool kUnderAddressSanitizer = false;
#endif

/// Bytes of address space in use; 0 when the system does not say.
unsigned long long addressSpaceInUse() {
  std::FILE* statm = std::fopen("/proc/self/statm", "re");
  if (statm == nullptr) return 0;
  unsigned long long pages = 0;
  const int read = std::fscanf(statm, "%llu", &pages);
  std::fclose(statm);
  return read == 1 ? pages * static_cast<unsigned long long>(sysconf(_SC_PAGESIZE)) : 0;
}

}  // namespace

MemoryLimit::MemoryLimit(std::size_t bytes) {
  if (kUnderAddressSanitizer) return;
  rlimit limit{};
  const unsigned long long in_use = addressSpaceInUse();
  if (in_use == 0 || getrlimit(RLIMIT_AS, &limit) != 0) return;
  previous_ = limit.rlim_cur;
  if (in_use + bytes >= limit.rlim_cur) return;
  limit.rlim_cur = in_use + bytes;
  active_ = setrlimit(RLIMIT_AS, &limit) == 0;
}

MemoryLimit::~MemoryLimit() {
  if (!active_) return;
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0) return;
  limit.rlim_cur = previous_;
  setrlimit(RLIMIT_AS, &limit);
}

}  // namespace dynemo
