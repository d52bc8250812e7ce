#include "tag_pattern.h"

#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>

#include <cstdlib>
#include <memory>
#include <stdexcept>

namespace dynemo::simulation {
namespace {

/// image_u8_destroy is in another library; it is two calls of free.
void freeImage(image_u8_t* image) {
  std::free(image->buf);
  std::free(image);
}

}  // namespace

TagPatterns::TagPatterns(const std::vector<int>& tag_ids) {
  const std::unique_ptr<apriltag_family_t, void (*)(apriltag_family_t*)> family(tag36h11_create(),
                                                                                tag36h11_destroy);
  for (const int id : tag_ids) {
    const std::unique_ptr<image_u8_t, void (*)(image_u8_t*)> image(
        apriltag_to_image(family.get(), static_cast<std::uint32_t>(id)), freeImage);
    if (image->width != kSheetCells || image->height != kSheetCells)
      throw std::logic_error("tag36h11 is not drawn as 10 by 10 cells");
    TagPattern& pattern = patterns_[id];
    for (int row = 0; row < kSheetCells; ++row) {
      for (int column = 0; column < kSheetCells; ++column)
        pattern[static_cast<std::size_t>(row * kSheetCells + column)] =
            image->buf[row * image->stride + column] > 127;
    }
  }
}

}  // namespace dynemo::simulation
