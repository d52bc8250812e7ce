// Semantic classes of points as the cloud formats write them.
#pragma once

#include <cstdint>

#include "dynemo/graph/node_entity.h"

namespace dynemo {

enum class PointClass : std::uint8_t { kStructure = 0, kObject = 1, kAgent = 2 };

PointClass pointClass(SemanticClass semantic_class);
const char* pointClassName(PointClass c);
/// 0xRRGGBB.
std::uint32_t pointClassColor(PointClass c);

}  // namespace dynemo
