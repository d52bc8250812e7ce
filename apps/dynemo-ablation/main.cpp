// dynemo-ablation: the paper's experiments, setups by datasets by seeds, as tables, figures and a
// report.
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <map>
#include <optional>

#include "../common/number_range.h"
#include "../common/program.h"
#include "dynemo/core/config.h"
#include "dynemo/core/output_file.h"
#include "dynemo/experiments/report.h"
#include "study.h"

namespace fs = std::filesystem;

namespace dynemo {
namespace {

struct Options {
  std::string plan = "paper";
  std::vector<std::string> datasets, setups, odometries;
  std::optional<int> seeds;
  std::optional<std::string> scale;
  std::optional<double> duration_s;
  int jobs = 1;
  fs::path output;
  bool quiet = false;
};

void declare(CLI::App& app, Options& o) {
  app.add_option("--output", o.output,
                 "Folder for datasets, runs and report; a second call continues in it")
      ->required()
      ->type_name("DIR");
  app.add_option("--plan", o.plan, "smoke, paper, or a YAML file; the options below override it")
      ->type_name("NAME|FILE");
  app.add_option("--datasets", o.datasets, "Datasets of dynemo-simulate")
      ->delimiter(',')
      ->type_name("A,B,…");
  app.add_option("--setups", o.setups, "Setups of dynemo-slam")->delimiter(',')->type_name("A,B,…");
  app.add_option("--odometries", o.odometries, "keyframe_gicp (the baseline's), local_map, rawlog")
      ->delimiter(',')
      ->type_name("A,B,…");
  app.add_option("--seeds", o.seeds, "Datasets of each kind")
      ->check(CLI::Range(1, 1000))
      ->type_name("N");
  app.add_option("--scale", o.scale, "Size of the datasets")
      ->check(CLI::IsMember({"mini", "full"}))
      ->type_name("mini|full");
  app.add_option("--duration", o.duration_s, "Seconds instead of the datasets' own length")
      ->check(positiveNumber())
      ->type_name("S");
  app.add_option("--jobs", o.jobs, "Runs at once; they share the cores, which shows in their times")
      ->check(CLI::Range(1, 256))
      ->type_name("N");
  app.add_flag("-q,--quiet", o.quiet, "Print errors only");
  app.set_version_flag("--version", "dynemo-ablation " DYNEMO_VERSION);
}

/// share/dynemo beside the program's own folder, in the build tree as when installed.
fs::path shareFolder() {
  return fs::read_symlink("/proc/self/exe").parent_path().parent_path() / "share" / "dynemo";
}

experiments::ExperimentPlan choosePlan(const Options& o) {
  const fs::path installed = shareFolder() / "config" / "ablation" / (o.plan + ".yaml");
  ConfigLoader loader;
  loader.addFile(fs::exists(installed) ? installed : fs::path(o.plan));
  experiments::ExperimentPlan plan;
  load(loader, plan);
  if (!o.datasets.empty()) plan.datasets = o.datasets;
  if (!o.setups.empty()) plan.setups = o.setups;
  if (!o.odometries.empty()) plan.odometries = o.odometries;
  if (o.seeds) plan.seeds = *o.seeds;
  if (o.scale) plan.scale = *o.scale;
  if (o.duration_s) plan.duration_s = *o.duration_s;
  return plan;
}

int run(const Options& o) {
  const experiments::ExperimentPlan plan = choosePlan(o);
  prepareFolderOf(o.output / "report.html");
  StudyOptions study{o.output, o.jobs, {}};
  if (!o.quiet) {
    study.on_result = [](const experiments::RunResult& r, std::size_t done, std::size_t of) {
      std::printf("[%zu/%zu] %s: ATE %.2f cm\n", done, of, r.key.path().c_str(),
                  100 * r.ate_rmse_m);
      std::fflush(stdout);
    };
  }
  const StudyOutcome outcome = carryOut(plan, study);
  if (outcome.results.empty())
    throw DataError("no run succeeded: " +
                    (outcome.missing.empty() ? "" : outcome.missing.front()));

  const auto paper = experiments::PaperTables::read(shareFolder() / "paper");
  std::map<std::string, fs::path> worlds;
  for (const std::string& dataset : plan.datasets) {
    const fs::path world = worldFile(o.output, dataset);
    if (fs::exists(world)) worlds[dataset] = world;
  }
  const auto figures = experiments::drawFigures(outcome.results, worlds, o.output / "figures");
  writeFileAtomically(o.output / "runs.csv", experiments::runsCsv(outcome.results));
  writeFileAtomically(o.output / "tables.csv",
                      experiments::tablesCsv(experiments::cellsOf(outcome.results), paper));
  writeFileAtomically(o.output / "entities.csv", experiments::entitiesCsv(outcome.results));
  writeFileAtomically(
      o.output / "report.html",
      experiments::reportHtml({plan, outcome.results, outcome.missing, paper, figures}));
  for (const std::string& text : outcome.missing) std::cerr << "dynemo-ablation: " << text << '\n';
  if (!o.quiet) std::cout << "report  " << (o.output / "report.html").string() << '\n';
  return outcome.missing.empty() ? 0 : static_cast<int>(ExitStatus::kData);
}

}  // namespace
}  // namespace dynemo

int main(int argc, char** argv) {
  CLI::App app(
      "The experiments of the paper: simulates the datasets, runs the setups, and sets the figures "
      "beside the "
      "paper's.",
      "dynemo-ablation");
  dynemo::Options options;
  dynemo::declare(app, options);
  return dynemo::runProgram(app, argc, argv, [&] { return dynemo::run(options); });
}
