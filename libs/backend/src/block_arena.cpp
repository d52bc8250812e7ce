#include "block_arena.h"

#include <bit>

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

}  // namespace

void BlockArena::reserve(Block& block, std::size_t size) {
  if (block.data && block.capacity >= size) return;
  release(block);
  const SizeClass c = sizeClass(size);
  auto& free = free_[c.index];
  if (free.empty()) {
    block.data = carve(c.size);
  } else {
    block.data = free.back();
    free.pop_back();
  }
  block.size_class = c.index;
  block.capacity = c.size;
}

void BlockArena::release(Block& block) {
  if (block.data) free_[block.size_class].push_back(block.data);
  block = {};
}

double* BlockArena::carve(std::size_t size) {
  if (size > kChunk / 4) {
    // Keeps the chunk in use as the last one.
    chunks_.insert(chunks_.empty() ? chunks_.end() : chunks_.end() - 1,
                   std::make_unique_for_overwrite<double[]>(size));
    capacity_ += size;
    double* const data = chunks_.size() == 1 ? chunks_.front().get() : (chunks_.end() - 2)->get();
    if (chunks_.size() == 1) chunk_used_ = kChunk;
    return data;
  }
  if (chunk_used_ + size > kChunk) {
    chunks_.push_back(std::make_unique_for_overwrite<double[]>(kChunk));
    capacity_ += kChunk;
    chunk_used_ = 0;
  }
  double* const data = chunks_.back().get() + chunk_used_;
  chunk_used_ += size;
  return data;
}

}  // namespace dynemo::backend
