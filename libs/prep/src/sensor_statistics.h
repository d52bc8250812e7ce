// The first half of an inspection: the objects of a rawlog as they are stored.
#pragma once

#include "dynemo/prep/inspection.h"

namespace dynemo {

/// Fills everything but what dynemo-slam makes of the log.
void inspectObjects(const std::filesystem::path& rawlog, const InspectionParams& params,
                    Inspection& inspection);

/// What could be better, from all that was found.
void judge(const InspectionParams& params, Inspection& inspection);

}  // namespace dynemo
