// Storage of the fronts' numbers.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

namespace dynemo::backend {

/// Hands out blocks of doubles from large chunks and takes them back for blocks of similar size, so
/// that a front that is factorised again, or grows a little, needs no allocation. Big blocks are
/// mapped one by one, and only few of them stand by. All are pages of the system: on the heap they
/// would leave holes.
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
  /// Whether big blocks stand by however many are free, and after clear() as many as were in use:
  /// for those who soon want the like again.
  void keepBig(bool keep) { keeps_big_ = keep; }
  /// Takes back everything; blocks that are still about must be forgotten.
  void clear();
  /// Doubles in all chunks and big blocks.
  std::size_t capacity() const { return chunks_.size() * kChunk + big_size_; }

 private:
  struct Unmap {
    std::size_t size;
    void operator()(double* data) const;
  };
  using Pages = std::unique_ptr<double[], Unmap>;

  static constexpr std::size_t kChunk = std::size_t{1} << 18;
  static constexpr std::size_t kBig = std::size_t{1} << 16;
  /// Four classes to every doubling.
  static constexpr int kClasses = 160;

  /// Pages that the system provides at once, when all are wanted, or one by one.
  static Pages map(std::size_t size, bool all_at_once);
  double* carve(std::size_t size);

  /// Of kChunk doubles; those before the current one are in use.
  std::vector<Pages> chunks_;
  std::size_t current_ = 0, chunk_used_ = 0;
  struct Big {
    Pages data;
    int size_class;
  };
  std::vector<Big> big_;
  bool keeps_big_ = false;
  std::size_t big_size_ = 0, big_free_ = 0;
  std::array<std::vector<double*>, kClasses> free_;
};

}  // namespace dynemo::backend
