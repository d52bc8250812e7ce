// Whether dynemo-slam accepts the configurations of a work list, before anything is run.
#pragma once

#include <filesystem>
#include <vector>

#include "dynemo/batch/work_list.h"

namespace dynemo {

/// Lets `program` (dynemo-slam) read the configuration of each setup. Throws ConfigError with what
/// it says against one, and DataError when it cannot be started.
void requireConfigurations(const std::vector<WorkItem>& items,
                           const std::filesystem::path& program);

}  // namespace dynemo
