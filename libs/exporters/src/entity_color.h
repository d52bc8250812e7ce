#pragma once

#include <cstdint>

#include "dynemo/core/ids.h"

namespace dynemo {

/// Well separated colours, the same for one entity in every run; 0xRRGGBB.
std::uint32_t entityRgb(EntityId id);

}  // namespace dynemo
