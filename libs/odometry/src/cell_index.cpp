#include "dynemo/odometry/cell_index.h"

#include <algorithm>
#include <bit>

namespace dynemo {

CellIndex::CellIndex(std::size_t expected_cells)
    : slots_(std::bit_ceil(std::max<std::size_t>(16, 2 * expected_cells))),
      mask_(slots_.size() - 1) {}

std::uint32_t CellIndex::findOrAdd(const CellCoordinates& cell) {
  const std::uint64_t key = keyOf(cell);
  std::size_t slot = hash(key) & mask_;
  for (; slots_[slot].number != kNone; slot = (slot + 1) & mask_) {
    if (slots_[slot].key == key) return slots_[slot].number;
  }
  slots_[slot] = {key, static_cast<std::uint32_t>(size_++)};
  const std::uint32_t number = slots_[slot].number;
  if (2 * size_ > slots_.size()) grow();
  return number;
}

void CellIndex::clear() {
  std::fill(slots_.begin(), slots_.end(), Slot{});
  size_ = 0;
}

void CellIndex::grow() {
  std::vector<Slot> old(2 * slots_.size());
  old.swap(slots_);
  mask_ = slots_.size() - 1;
  for (const Slot& entry : old) {
    if (entry.number == kNone) continue;
    std::size_t slot = hash(entry.key) & mask_;
    while (slots_[slot].number != kNone) slot = (slot + 1) & mask_;
    slots_[slot] = entry;
  }
}

}  // namespace dynemo
