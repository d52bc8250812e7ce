// What every program does the same way: exit statuses, one-line errors, --version.
#pragma once

#include <CLI/CLI.hpp>
#include <exception>
#include <functional>
#include <iostream>
#include <string>

#include "command_line_error.h"
#include "dynemo/core/error.h"

namespace dynemo {

/// Parses the command line and runs the body; the only place where exceptions end. Usage and
/// configuration errors exit with 2, data errors with 3, anything else with 4, each after one
/// message on stderr.
inline int runProgram(CLI::App& app, int argc, char** argv, const std::function<int()>& body) {
  const auto fail = [&app](const std::string& what, ExitStatus status) {
    std::cerr << app.get_name() << ": " << what << '\n';
    return static_cast<int>(status);
  };
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& e) {
    return app.exit(e);  // --help, --version
  } catch (const CLI::ParseError& e) {
    std::string help = app.get_name();
    for (const CLI::App* command : app.get_subcommands()) help += " " + command->get_name();
    return fail(commandLineError(app, e) + " (see " + help + " --help)", ExitStatus::kUsage);
  } catch (const ConfigError& e) {
    return fail(e.what(), ExitStatus::kUsage);
  } catch (const DataError& e) {
    return fail(e.what(), ExitStatus::kData);
  }
  try {
    return body();
  } catch (const ConfigError& e) {
    return fail(e.what(), ExitStatus::kUsage);
  } catch (const DataError& e) {
    return fail(e.what(), ExitStatus::kData);
  } catch (const std::exception& e) {
    return fail(std::string("internal error: ") + e.what(), ExitStatus::kInternal);
  }
}

}  // namespace dynemo
