// dynemo-simulate: a dataset of the paper, or a world of one's own, as a rawlog with ground truth.
#include <mrpt/maps/registerAllClasses.h>

#include <atomic>
#include <csignal>
#include <filesystem>
#include <iostream>
#include <optional>
#include <thread>

#include "../common/program.h"
#include "../common/progress.h"
#include "dynemo/simulation/datasets.h"
#include "dynemo/simulation/simulation.h"
#include "dynemo/simulation/world_file.h"

namespace fs = std::filesystem;

namespace dynemo {
namespace {

std::atomic<bool> interrupted{false};
constexpr int kInterruptedStatus = 130;

struct Options {
  std::optional<std::string> dataset, name;
  std::optional<fs::path> world, output;
  std::string scale = "full";
  std::optional<int> seed;
  std::optional<double> duration_s;
  std::optional<std::string> motion_distortion;
  int threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  bool no_noise = false, dump_world = false, list = false, quiet = false;
};

void declare(CLI::App& app, Options& o) {
  const auto on_off = CLI::IsMember({"on", "off"});
  app.add_option("DATASET", o.dataset, "One of those that --list prints")->type_name("");
  app.add_option("--output", o.output, "Folder for the dataset (created)")->type_name("DIR");
  app.add_option("--world", o.world, "World file instead of DATASET")->type_name("FILE");
  app.add_option("--seed", o.seed, "Another dataset of the same kind for each seed; default 1")
      ->check(CLI::Range(0, 10000))
      ->type_name("N");
  app.add_option("--scale", o.scale, "mini: small and coarse, for tests; full: as in the paper")
      ->check(CLI::IsMember({"mini", "full"}))
      ->type_name("mini|full");
  app.add_option("--duration", o.duration_s, "Length in seconds instead of the dataset's own")
      ->check(CLI::Range(0.1, 86400.0))
      ->type_name("S");
  app.add_option("--motion-distortion", o.motion_distortion,
                 "Whether the LiDAR moves during a sweep; default: hand-held datasets only")
      ->check(on_off)
      ->type_name("on|off");
  app.add_option("--name", o.name, "Name of the files instead of the dataset's")->type_name("NAME");
  app.add_option("--threads", o.threads, "Threads; the result does not depend on it")
      ->check(CLI::Range(1, 256))
      ->type_name("N");
  app.add_flag("--no-noise", o.no_noise, "Perfect sensors and odometry");
  app.add_flag("--dump-world", o.dump_world, "Print the world as a world file and exit");
  app.add_flag("--list", o.list, "Print the datasets and exit");
  app.add_flag("-q,--quiet", o.quiet, "Print errors only");
  app.set_version_flag("--version", "dynemo-simulate " DYNEMO_VERSION);
}

simulation::World chooseWorld(const Options& o) {
  using namespace simulation;
  if (o.dataset.has_value() == o.world.has_value())
    throw ConfigError("either DATASET or --world is required (see dynemo-simulate --help)");
  World world;
  if (o.world) {
    world = readWorld(*o.world);
    if (o.seed) world.seed = *o.seed;
    if (o.duration_s) world.duration_s = *o.duration_s;
    if (o.motion_distortion) world.sensors.lidar.motion_distortion = *o.motion_distortion == "on";
  } else {
    DatasetOptions options;
    options.scale = o.scale == "mini" ? Scale::kMini : Scale::kFull;
    options.seed = o.seed.value_or(options.seed);
    options.duration_s = o.duration_s;
    if (o.motion_distortion) options.motion_distortion = *o.motion_distortion == "on";
    world = makeDataset(*o.dataset, options);
  }
  if (o.name) world.name = *o.name;
  if (o.no_noise) world.sensors.noise = false;
  return world;
}

int run(const Options& o) {
  if (o.list) {
    for (const std::string& name : simulation::datasetNames()) std::cout << name << '\n';
    return 0;
  }
  const simulation::World world = chooseWorld(o);
  if (o.dump_world) {
    std::cout << simulation::worldYaml(world) << std::flush;
    if (!std::cout) throw DataError("standard output: cannot be written");
    return 0;
  }
  if (!o.output) throw ConfigError("--output is required (see dynemo-simulate --help)");
  Progress progress(!o.quiet);
  const auto counts = simulation::simulate(world, *o.output, o.threads, [&](double t_s) {
    progress.update(t_s / world.duration_s, t_s);
    return !interrupted;
  });
  progress.clear();
  if (!o.quiet) {
    const double wall_s = progress.elapsed_s();
    std::cout << "scans     " << counts.scans << "\nimages    " << counts.images << "\npoints    "
              << counts.points << "\ntime      " << wall_s << " s for " << world.duration_s
              << " s of data (" << world.duration_s / wall_s << "x real time)\ndataset   "
              << (*o.output / (world.name + ".rawlog")).string() << '\n';
  }
  return interrupted ? kInterruptedStatus : 0;
}

}  // namespace
}  // namespace dynemo

int main(int argc, char** argv) {
  for (const int signal : {SIGINT, SIGTERM})
    std::signal(signal, [](int) { dynemo::interrupted = true; });
  mrpt::maps::registerAllClasses_mrpt_maps();
  CLI::App app(
      "Simulates the datasets of the paper, or a world of one's own: an MRPT rawlog with LiDAR, "
      "camera and "
      "odometry, and ground truth.",
      "dynemo-simulate");
  dynemo::Options options;
  dynemo::declare(app, options);
  return dynemo::runProgram(app, argc, argv, [&] { return dynemo::run(options); });
}
