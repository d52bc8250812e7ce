// A flat hash table from cells of a regular grid to consecutive numbers.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <vector>

namespace dynemo {

/// Integer coordinates of a grid cell.
using CellCoordinates = Eigen::Vector3i;

/// The cell that holds p. Coordinates are limited to ±2²⁰, the range of the table's keys.
inline CellCoordinates cellOf(const Eigen::Vector3f& p, float inverse_cell_size) {
  constexpr float kLimit = 1048575.0F;
  const auto axis = [&](float v) {
    return static_cast<int>(
        std::floor(std::fmin(std::fmax(v * inverse_cell_size, -kLimit), kLimit)));
  };
  return {axis(p.x()), axis(p.y()), axis(p.z())};
}

/// Open addressing with linear probing; numbers are given in the order of insertion, so nothing
/// depends on the table's layout.
class CellIndex {
 public:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;

  explicit CellIndex(std::size_t expected_cells = 64);

  /// The cell's number, kNone when it is unknown.
  std::uint32_t find(const CellCoordinates& cell) const {
    const std::uint64_t key = keyOf(cell);
    for (std::size_t slot = hash(key) & mask_;; slot = (slot + 1) & mask_) {
      if (slots_[slot].number == kNone || slots_[slot].key == key) return slots_[slot].number;
    }
  }
  /// The cell's number; an unknown cell gets the next one, size() before the call.
  std::uint32_t findOrAdd(const CellCoordinates& cell);
  std::size_t size() const { return size_; }
  void clear();

 private:
  struct Slot {
    std::uint64_t key = 0;
    std::uint32_t number = kNone;
  };

  static std::uint64_t keyOf(const CellCoordinates& c) {
    constexpr std::uint64_t kMask = (1U << 21U) - 1U;
    return (static_cast<std::uint64_t>(static_cast<std::uint32_t>(c.x())) & kMask) |
           ((static_cast<std::uint64_t>(static_cast<std::uint32_t>(c.y())) & kMask) << 21U) |
           ((static_cast<std::uint64_t>(static_cast<std::uint32_t>(c.z())) & kMask) << 42U);
  }
  /// Finaliser of SplitMix64 (Steele et al. 2014), shortened: all key bits reach the low bits.
  static std::size_t hash(std::uint64_t key) {
    key = (key ^ (key >> 31U)) * 0x9E3779B97F4A7C15ULL;
    return static_cast<std::size_t>(key ^ (key >> 29U));
  }
  void grow();

  std::vector<Slot> slots_;
  std::size_t mask_ = 0;
  std::size_t size_ = 0;
};

}  // namespace dynemo
