#include "entity_color.h"

#include <mrpt/img/color_maps.h>

#include <cmath>
#include <numbers>

namespace dynemo {

std::uint32_t entityRgb(EntityId id) {
  // Steps of the golden ratio around the hue circle never come close to each other soon.
  const double turns = std::numbers::phi * static_cast<double>(id.value);
  float r = 0, g = 0, b = 0;
  mrpt::img::hsv2rgb(static_cast<float>(turns - std::floor(turns)), 0.85f, 0.8f, r, g, b);
  const auto byte = [](float v) { return static_cast<std::uint32_t>(std::lround(255.0f * v)); };
  return byte(r) << 16u | byte(g) << 8u | byte(b);
}

}  // namespace dynemo
