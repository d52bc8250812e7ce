// What a rawlog holds, for tests of the programs that write rawlogs.
#pragma once

#include <mrpt/obs/CObservation.h>

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "dynemo/core/time.h"

namespace dynemo::test {

/// One observation: class, label, stamp and its bytes as MRPT writes it.
struct WrittenObservation {
  std::string class_name, label;
  Stamp stamp;
  std::shared_ptr<mrpt::obs::CObservation> object;
  std::string bytes;
};

/// All observations in the order of the file; fails the test when the file is damaged.
std::vector<WrittenObservation> readLog(const std::filesystem::path& rawlog);

/// Number of observations by label.
std::map<std::string, int> countByLabel(const std::vector<WrittenObservation>& log);

/// Names of the files in a folder, temporary ones included.
std::vector<std::string> filesIn(const std::filesystem::path& folder);

}  // namespace dynemo::test
