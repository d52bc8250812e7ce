// dynemo-eval: trajectory and entity errors of a run against ground truth.
#include <CLI/CLI.hpp>
#include <exception>
#include <filesystem>
#include <iostream>
#include <optional>
#include <string>

#include "dynemo/core/error.h"
#include "dynemo/core/output_file.h"
#include "dynemo/evaluation/run_report.h"

namespace {

using dynemo::ExitStatus;

struct Options {
  std::string reference, entities_reference, json, run;
};

void declare(CLI::App& app, Options& options) {
  app.set_version_flag("--version", std::string("dynemo-eval ") + DYNEMO_VERSION);
  app.add_option("--reference", options.reference,
                 "Ground truth trajectory: lines 'timestamp x y z qx qy qz qw'")
      ->required()
      ->type_name("GT.tum");
  app.add_option("--entities-reference", options.entities_reference,
                 "Ground truth of the entities: entity_id,class,timestamp,x,y,z,qx,qy,qz,qw")
      ->type_name("GT.csv");
  app.add_option("--json", options.json, "Also write the figures to this file")->type_name("FILE");
  app.add_option("run", options.run, "Output folder of a run, or one trajectory in TUM form")
      ->required()
      ->type_name("RUN_DIR");
  app.footer(
      "Trajectories are associated by nearest stamp (0.01 s) and aligned by a rigid motion "
      "without scale.\nExit status: 0 ok, 2 usage, 3 data, 4 internal error.");
}

void evaluate(const Options& options) {
  if (!options.entities_reference.empty() && std::filesystem::is_regular_file(options.run)) {
    throw dynemo::ConfigError("--entities-reference: needs a run's folder; " + options.run +
                              " is a single trajectory");
  }
  if (!options.json.empty()) dynemo::prepareFolderOf(options.json);
  const dynemo::Trajectory reference = dynemo::readTum(options.reference);
  std::optional<dynemo::EntityTruths> truths;
  if (!options.entities_reference.empty()) {
    truths = dynemo::readEntityTruths(options.entities_reference);
  }
  const dynemo::RunReport report =
      dynemo::evaluateRun(options.run, reference, truths ? &*truths : nullptr);
  std::cout << dynemo::reportText(report) << std::flush;
  if (!std::cout) throw dynemo::DataError("standard output: cannot be written");
  if (!options.json.empty()) dynemo::writeFileAtomically(options.json, dynemo::reportJson(report));
}

int fail(ExitStatus status, const std::string& message) {
  std::cerr << "dynemo-eval: " << message << "\n";
  return static_cast<int>(status);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Errors of a dynemo-slam run against ground truth.", "dynemo-eval");
  try {
    declare(app, options);
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? static_cast<int>(ExitStatus::kOk)
                            : static_cast<int>(ExitStatus::kUsage);
  }
  try {
    evaluate(options);
    return static_cast<int>(ExitStatus::kOk);
  } catch (const dynemo::ConfigError& e) {
    return fail(ExitStatus::kUsage, e.what());
  } catch (const dynemo::DataError& e) {
    return fail(ExitStatus::kData, e.what());
  } catch (const std::exception& e) {
    return fail(ExitStatus::kInternal, std::string("internal error: ") + e.what());
  }
}
