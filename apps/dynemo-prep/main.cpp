// dynemo-prep: looks into rawlogs and makes them fit for dynemo-slam.
#include "../common/program.h"
#include "commands.h"

int main(int argc, char** argv) {
  CLI::App app(
      "Looks into MRPT rawlogs and makes them fit for dynemo-slam. Inputs are never changed, and a "
      "result appears only when it is complete.",
      "dynemo-prep");
  app.set_version_flag("--version", "dynemo-prep " DYNEMO_VERSION);
  app.set_help_all_flag("--help-all", "Print the help of every command and exit");
  app.require_subcommand(1);
  app.footer(
      "For more, mrpt-apps has rawlog-edit: keep or remove labels, remap time stamps, list poses "
      "and images,\nundistort, export GPS and IMU readings.\n"
      "Exit status: 0 ok, 1 check: dynemo-slam cannot run it, 2 usage, 3 data, 4 internal error.");
  std::vector<dynemo::Command> commands;
  dynemo::declareCheck(app, commands);
  dynemo::declareTags(app, commands);
  dynemo::declareCuts(app, commands);
  dynemo::declareSensorEdits(app, commands);
  dynemo::declareAnnotate(app, commands);
  dynemo::declareImport(app, commands);
  dynemo::declareExport(app, commands);
  return dynemo::runProgram(app, argc, argv, [&] {
    for (const dynemo::Command& command : commands)
      if (command.app->parsed()) return command.run();
    return 0;
  });
}
