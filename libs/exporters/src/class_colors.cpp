#include "class_colors.h"

namespace dynemo {

PointClass pointClass(SemanticClass semantic_class) {
  return semantic_class == SemanticClass::kAgent ? PointClass::kAgent : PointClass::kObject;
}

const char* pointClassName(PointClass c) {
  constexpr const char* kNames[] = {"structure", "object", "agent"};
  return kNames[static_cast<int>(c)];
}

std::uint32_t pointClassColor(PointClass c) {
  constexpr std::uint32_t kColors[] = {0x8c96a3, 0xf28e2b, 0xd62f4b};
  return kColors[static_cast<int>(c)];
}

}  // namespace dynemo
