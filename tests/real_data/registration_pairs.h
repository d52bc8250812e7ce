// Pairs of real scans with reference poses, read for tests of scan matching.
#pragma once

#include <filesystem>
#include <optional>

#include "dynemo/core/point_cloud.h"

namespace dynemo::test {

struct RegistrationPair {
  Scan target, source;
};

/// Two outdoor scans of a car, and T_target_source.
RegistrationPair readSmallGicpPair(const std::filesystem::path& registration_folder,
                                   Pose3& T_target_source);
/// Two indoor scans of a tilting laser.
RegistrationPair readApartmentPair(const std::filesystem::path& registration_folder);
/// Two scans of a room.
RegistrationPair readPclRoomPair(const std::filesystem::path& registration_folder);

}  // namespace dynemo::test
