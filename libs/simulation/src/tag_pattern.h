// The printed pattern of an AprilTag, from libapriltag's own drawing.
#pragma once

#include <array>
#include <map>
#include <vector>

namespace dynemo::simulation {

constexpr int kTagFamilySize = 587;  ///< of tag36h11
constexpr int kSheetCells = 10;      ///< white border included

/// true: white. Row by row, from the upper left of the upright sheet.
using TagPattern = std::array<bool, kSheetCells * kSheetCells>;

class TagPatterns {
 public:
  /// Draws the given tags of the family tag36h11.
  explicit TagPatterns(const std::vector<int>& tag_ids);
  const TagPattern& of(int tag_id) const { return patterns_.at(tag_id); }

 private:
  std::map<int, TagPattern> patterns_;
};

}  // namespace dynemo::simulation
