#include "block_arena.h"

#include <algorithm>
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

/// Of the blocks of a class.
std::size_t sizeOf(int index) {
  const int exponent = 5 + index / 4;
  return (std::size_t{1} << exponent) +
         static_cast<std::size_t>(index % 4) * (std::size_t{1} << (exponent - 2));
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

void BlockArena::clear() {
  // Large ones that were in use stand by as they are, so that memory follows the need; the chunks
  // are cut anew.
  std::erase_if(large_, [this](const auto& block) {
    const auto& free = free_[static_cast<std::size_t>(block.first)];
    const bool unused = std::find(free.begin(), free.end(), block.second.get()) != free.end();
    if (unused) capacity_ -= sizeOf(block.first);
    return unused;
  });
  for (auto& list : free_) list.clear();
  for (const auto& [size_class, data] : large_) free_[size_class].push_back(data.get());
  current_ = chunk_used_ = 0;
}

double* BlockArena::carve(std::size_t size) {
  if (size > kChunk / 4) {
    large_.emplace_back(sizeClass(size).index, std::make_unique_for_overwrite<double[]>(size));
    capacity_ += size;
    return large_.back().second.get();
  }
  if (current_ < chunks_.size() && chunk_used_ + size > kChunk) {
    ++current_;
    chunk_used_ = 0;
  }
  if (current_ == chunks_.size()) {
    chunks_.push_back(std::make_unique_for_overwrite<double[]>(kChunk));
    capacity_ += kChunk;
  }
  double* const data = chunks_[current_].get() + chunk_used_;
  chunk_used_ += size;
  return data;
}

}  // namespace dynemo::backend
