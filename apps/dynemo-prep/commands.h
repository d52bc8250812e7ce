// The commands of dynemo-prep. Each declare function adds one or more to the program.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <vector>

namespace dynemo {

struct Command {
  CLI::App* app;
  std::function<int()> run;  ///< returns the exit status
};

void declareCheck(CLI::App& program, std::vector<Command>& commands);
void declareTags(CLI::App& program, std::vector<Command>& commands);
/// trim, split, decimate, merge
void declareCuts(CLI::App& program, std::vector<Command>& commands);
/// set-extrinsics, set-calibration, relabel, externalize-images
void declareSensorEdits(CLI::App& program, std::vector<Command>& commands);
void declareAnnotate(CLI::App& program, std::vector<Command>& commands);
void declareImport(CLI::App& program, std::vector<Command>& commands);
void declareExport(CLI::App& program, std::vector<Command>& commands);

}  // namespace dynemo
