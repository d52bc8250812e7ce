// Runs a program and waits for it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace dynemo::experiments {

/// What the program prints goes to `log`. Returns the exit status, or 128 + signal. Throws
/// DataError when the program cannot be started.
int runProcess(const std::vector<std::string>& command, const std::filesystem::path& log);

}  // namespace dynemo::experiments
