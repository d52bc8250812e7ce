// What an observation stores outside of the rawlog.
#pragma once

#include <mrpt/obs/CObservation.h>

#include <string>
#include <vector>

namespace dynemo {

/// Names of the files, as stored: images, range images and clouds.
std::vector<std::string> externalFiles(const mrpt::obs::CObservation& observation);

/// Makes an image of the observation refer to another file. False when `old_name` is not the name
/// of an image: range images and clouds cannot be renamed.
bool renameExternalImage(mrpt::obs::CObservation& observation, const std::string& old_name,
                         const std::string& new_name);

}  // namespace dynemo
