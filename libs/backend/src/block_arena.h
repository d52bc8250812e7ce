// Storage of the fronts' numbers.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

namespace dynemo::backend {

/// Hands out blocks of doubles from large chunks and takes them back for blocks of similar size, so
/// that a front that is factorised again, or grows a little, needs no allocation.
class BlockArena {
 public:
  struct Block {
    double* data = nullptr;
    int size_class = -1;
    std::size_t capacity = 0;
  };

  BlockArena() = default;
  BlockArena(BlockArena&&) = default;
  BlockArena& operator=(BlockArena&&) = default;

  /// Makes `block` hold at least `size` doubles; what it held is lost.
  void reserve(Block& block, std::size_t size);
  void release(Block& block);
  /// Takes back everything; blocks that are still about must be forgotten.
  void clear();
  /// Doubles in all chunks.
  std::size_t capacity() const { return capacity_; }

 private:
  static constexpr std::size_t kChunk = std::size_t{1} << 18;
  /// Four classes to every doubling.
  static constexpr int kClasses = 160;

  double* carve(std::size_t size);

  /// Of kChunk doubles; those before the current one are in use.
  std::vector<std::unique_ptr<double[]>> chunks_;
  std::size_t current_ = 0, chunk_used_ = 0;
  /// Of other sizes, by class.
  std::vector<std::pair<int, std::unique_ptr<double[]>>> large_;
  std::array<std::vector<double*>, kClasses> free_;
  std::size_t capacity_ = 0;
};

}  // namespace dynemo::backend
