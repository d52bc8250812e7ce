#include "block_arena.h"

#include <sys/mman.h>

#include <algorithm>
#include <bit>
#include <new>

namespace dynemo::backend {
namespace {

struct SizeClass {
  int index;
  std::size_t size;
};

/// The smallest (1 + q/4) · 2ᵉ ≥ size.
SizeClass sizeClass(std::size_t size) {
  constexpr std::size_t kSmallest = 32;
  if (size <= kSmallest) return {0, kSmallest};
  const int exponent = static_cast<int>(std::bit_width(size - 1)) - 1;
  const std::size_t quarter = std::size_t{1} << (exponent - 2);
  const std::size_t q = (size - (std::size_t{1} << exponent) + quarter - 1) / quarter;
  return {4 * (exponent - 5) + static_cast<int>(q), (std::size_t{1} << exponent) + q * quarter};
}

/// Of the blocks of a class.
std::size_t sizeOf(int index) {
  const int exponent = 5 + index / 4;
  return (std::size_t{1} << exponent) +
         static_cast<std::size_t>(index % 4) * (std::size_t{1} << (exponent - 2));
}

/// A free block that is too large by fewer classes than this does as well: fronts that grow leave
/// blocks behind that no other front fits exactly.
constexpr int kSlack = 4;
/// Of the big blocks this part at most, 1 / n, stands by.
constexpr std::size_t kBigFreeShare = 4;

}  // namespace

void BlockArena::Unmap::operator()(double* data) const { munmap(data, size * sizeof(double)); }

BlockArena::Pages BlockArena::map(std::size_t size, bool all_at_once) {
  void* const data = mmap(nullptr, size * sizeof(double), PROT_READ | PROT_WRITE,
                          MAP_PRIVATE | MAP_ANONYMOUS | (all_at_once ? MAP_POPULATE : 0), -1, 0);
  if (data == MAP_FAILED) throw std::bad_alloc();
  return Pages(static_cast<double*>(data), {size});
}

void BlockArena::reserve(Block& block, std::size_t size) {
  if (block.data && block.capacity >= size) return;
  release(block);
  const SizeClass c = sizeClass(size);
  block.size_class = c.index;
  block.capacity = c.size;
  for (int i = c.index; i < c.index + kSlack; ++i) {
    if (free_[i].empty()) continue;
    block.data = free_[i].back();
    block.size_class = i;
    block.capacity = sizeOf(i);
    free_[i].pop_back();
    if (block.capacity > kBig) big_free_ -= block.capacity;
    return;
  }
  if (c.size <= kBig) {
    block.data = carve(c.size);
    return;
  }
  block.data = big_.emplace_back(Big{map(c.size, true), c.index}).data.get();
  big_size_ += c.size;
}

void BlockArena::release(Block& block) {
  const bool is_big = block.data && block.capacity > kBig;
  if (is_big && !keeps_big_ && big_free_ + block.capacity > big_size_ / kBigFreeShare) {
    std::erase_if(big_, [&](const Big& big) { return big.data.get() == block.data; });
    big_size_ -= block.capacity;
  } else if (block.data) {
    if (is_big) big_free_ += block.capacity;
    free_[block.size_class].push_back(block.data);
  }
  block = {};
}

void BlockArena::clear() {
  // As many chunks stay as were in use, so that memory follows the need.
  chunks_.resize(std::min(chunks_.size(), current_ + 1));
  // So do big blocks, where the next factorisation wants their like.
  std::erase_if(big_, [&](const Big& big) {
    const auto& unused = free_[big.size_class];
    return !keeps_big_ || std::find(unused.begin(), unused.end(), big.data.get()) != unused.end();
  });
  for (auto& list : free_) list.clear();
  big_size_ = current_ = chunk_used_ = 0;
  for (const Big& big : big_) {
    free_[big.size_class].push_back(big.data.get());
    big_size_ += sizeOf(big.size_class);
  }
  big_free_ = big_size_;
}

double* BlockArena::carve(std::size_t size) {
  if (current_ < chunks_.size() && chunk_used_ + size > kChunk) {
    ++current_;
    chunk_used_ = 0;
  }
  if (current_ == chunks_.size()) chunks_.push_back(map(kChunk, !chunks_.empty()));
  double* const data = chunks_[current_].get() + chunk_used_;
  chunk_used_ += size;
  return data;
}

}  // namespace dynemo::backend
