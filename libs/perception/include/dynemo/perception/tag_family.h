// Ownership of libapriltag's tag families.
#pragma once

#include <memory>
#include <string>
#include <vector>

struct apriltag_family;

namespace dynemo {

using TagFamily = std::unique_ptr<apriltag_family, void (*)(apriltag_family*)>;

/// Throws ConfigError, listing the known names, when there is none of that name.
TagFamily makeTagFamily(const std::string& name);

std::vector<std::string> tagFamilyNames();

/// Number of codes, that is one more than the largest tag id.
int tagFamilySize(const apriltag_family& family);

}  // namespace dynemo
