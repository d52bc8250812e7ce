// dynemo-export: a finished run in another format.
#include <filesystem>
#include <iostream>
#include <optional>
#include <set>

#include "../common/program.h"
#include "../common/time_argument.h"
#include "dynemo/core/config.h"
#include "dynemo/core/output_file.h"
#include "dynemo/exporters/exporter.h"

namespace fs = std::filesystem;

namespace dynemo {
namespace {

struct Options {
  fs::path run, output;
  std::string format;
  std::optional<std::string> at;
  std::vector<std::string> overrides;
  bool dump_config = false;
};

std::string formatNames() {
  std::string list;
  for (const auto& name : exporters().names()) list += (list.empty() ? "" : ", ") + name;
  return list;
}

void declare(CLI::App& app, Options& o) {
  app.add_option("RUN_DIR", o.run, "Output folder of dynemo-slam")->required()->type_name("");
  app.add_option("--format", o.format, "One of: " + formatNames())->type_name("F");
  app.add_option("--output", o.output,
                 "File to write (a folder for formats of several files); inside an existing folder "
                 "it gets the name dynemo-slam would give it. An earlier one is replaced when the "
                 "export is complete; an ending that belongs to another format is refused")
      ->type_name("FILE");
  app.add_option("--at", o.at,
                 std::string("Map clouds: show entities as of this time; ") + kTimeHelp)
      ->type_name("T");
  app.add_option("--set", o.overrides,
                 "Override one option of the section `exports` of the configuration, e.g. --set "
                 "cloud.entities=none (repeatable)")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  app.add_flag("--dump-config", o.dump_config, "Print the effective options and exit");
  app.set_version_flag("--version", "dynemo-export " DYNEMO_VERSION);
}

void print(const std::string& text) {
  std::cout << text << std::flush;
  if (!std::cout) throw DataError("standard output: cannot be written");
}

/// The run's own options, overridden by the command line.
ExportParams exportParams(const Options& o, const Session& session) {
  ExportParams params = exportParamsOf(session.config_yaml);
  ConfigLoader loader;
  for (const std::string& text : o.overrides) loader.addOverride(text);
  load(loader, params);
  if (!o.at) return params;
  const std::set<std::string> clouds = {"ply", "pcd"};
  if (!o.dump_config && !clouds.contains(o.format)) {
    throw ConfigError("--at: format " + o.format + " shows all times; only ply and pcd show one");
  }
  if (session.frames.empty()) throw DataError(o.run.string() + ": the run has no frame");
  const RunSpan run = {session.frames.front().stamp, session.frames.back().stamp};
  params.cloud.at_s = secondsBetween(run.begin, parseTime(*o.at, run, "--at"));
  return params;
}

/// In a folder that is there, unless the format writes a folder itself under the very name.
fs::path outputFile(const Options& o, const Exporter& exporter) {
  const bool inside = fs::is_directory(o.output) && o.output.filename() != exporter.fileName();
  return inside ? o.output / exporter.fileName() : o.output;
}

int run(const Options& o) {
  if (!o.dump_config) {
    if (o.format.empty()) throw ConfigError("--format is required; known: " + formatNames());
    if (o.output.empty()) throw ConfigError("--output is required (see dynemo-export --help)");
    if (!exporters().contains(o.format))
      throw ConfigError("--format " + o.format + ": must be among: " + formatNames());
    if (!fs::is_directory(o.output)) checkFileName(o.format, o.output);
  }
  const Session session = loadRunSession(o.run);
  const ExportParams params = exportParams(o, session);
  if (o.dump_config) {
    print(toYaml(params));
    return 0;
  }
  const auto exporter = exporters().make(o.format, params);
  const fs::path output = outputFile(o, *exporter);
  prepareFolderOf(output);
  const bool replaces = fs::exists(output);
  exporter->write(resultOf(session), output);
  if (replaces) print("replaced    " + output.string() + "\n");
  return 0;
}

}  // namespace
}  // namespace dynemo

int main(int argc, char** argv) {
  CLI::App app("Writes a run of dynemo-slam in another format.", "dynemo-export");
  dynemo::Options options;
  dynemo::declare(app, options);
  return dynemo::runProgram(app, argc, argv, [&] { return dynemo::run(options); });
}
