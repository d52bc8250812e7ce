#include "dynemo/experiments/figures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>

#include "dynemo/core/child_process.h"
#include "dynemo/core/error.h"
#include "dynemo/core/output_file.h"
#include "dynemo/simulation/solids.h"
#include "dynemo/simulation/world_file.h"

namespace dynemo::experiments {
namespace {

namespace fs = std::filesystem;

/// Curves in blocks of one data file, and the script that draws them.
class Plot {
 public:
  Plot(std::string name, std::string caption, std::string settings)
      : name_(std::move(name)), caption_(std::move(caption)), settings_(std::move(settings)) {}

  void line(std::initializer_list<double> values) {
    std::string text;
    for (const double v : values) text += (text.empty() ? "" : " ") + exactNumber(v);
    data_ += text + "\n";
    empty_ = false;
  }
  /// A gap in the curve.
  void gap() { data_ += "\n"; }
  /// Ends the curve. `style` as in gnuplot's plot command.
  void curve(const std::string& title, const std::string& style,
             const std::string& columns = "1:2") {
    if (!empty_) {
      curves_ += (curves_.empty() ? "plot " : ", \\\n  ") + ("'" + name_ + ".dat' index ") +
                 std::to_string(blocks_++) + " using " + columns + " " + style +
                 (title.empty() ? " notitle" : " title '" + title + "'");
      data_ += "\n\n";
    }
    empty_ = true;
  }
  bool empty() const { return blocks_ == 0; }

  Figure draw(const fs::path& folder) const {
    writeFileAtomically(folder / (name_ + ".dat"), data_);
    const std::string script =
        "cd '" + folder.string() + "'\nset terminal svg size 760,420 dynamic font 'sans,11'\n" +
        "set output '" + name_ +
        ".svg'\nset encoding utf8\nset grid\nset key outside right noenhanced\n" + settings_ +
        curves_ + "\n";
    writeFileAtomically(folder / (name_ + ".gp"), script);
    const fs::path log = folder / (name_ + ".log");
    if (ChildProcess({"gnuplot", (folder / (name_ + ".gp")).string()}, log).wait().status != 0)
      throw DataError("gnuplot failed on " + (folder / (name_ + ".gp")).string() + "; see " +
                      log.string());
    std::ifstream in(folder / (name_ + ".svg"));
    std::stringstream svg;
    svg << in.rdbuf();
    if (svg.str().empty())
      throw DataError((folder / (name_ + ".svg")).string() + ": gnuplot wrote nothing");
    return {name_, caption_, svg.str()};
  }

 private:
  std::string name_, caption_, settings_, data_, curves_;
  int blocks_ = 0;
  bool empty_ = true;
};

template <class Of>
std::vector<std::string> distinct(const std::vector<RunResult>& results, Of of) {
  std::vector<std::string> names;
  for (const RunResult& r : results)
    if (std::find(names.begin(), names.end(), of(r)) == names.end()) names.push_back(of(r));
  return names;
}

std::string fileName(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); },
      '_');
  return text;
}

/// Mean error of the objects in view, in slices of time.
void addErrorCurve(const std::vector<const RunResult*>& runs, bool rotation,
                   const std::string& title, int colour, Plot& plot) {
  constexpr int kSlices = 24;
  double end_s = 0.0;
  for (const RunResult* run : runs)
    for (const EntitySample& s : run->entity_samples) end_s = std::max(end_s, s.t_s);
  std::array<double, kSlices> sum{}, count{};
  for (const RunResult* run : runs) {
    for (const EntitySample& s : run->entity_samples) {
      if (s.semantic_class != "object") continue;
      const auto slice = std::min<std::size_t>(
          kSlices - 1, static_cast<std::size_t>(kSlices * s.t_s / (end_s + 1e-9)));
      sum[slice] += rotation ? s.rotation_deg : 100.0 * s.translation_m;
      count[slice] += 1.0;
    }
  }
  for (std::size_t i = 0; i < kSlices; ++i)
    if (count[i] > 0)
      plot.line({(static_cast<double>(i) + 0.5) * end_s / kSlices, sum[i] / count[i]});
  plot.curve(title,
             "with linespoints pointsize 0.4 linewidth 1.5 linecolor " + std::to_string(colour));
}

void errorsOverTime(const std::vector<RunResult>& results, const std::string& dataset,
                    const std::string& odometry, bool timer, bool rotation,
                    std::vector<Plot>& plots) {
  const std::string what = rotation ? "rotation" : "position";
  Plot plot(
      fileName("entity_" + what + (timer ? "_timer_" : "_no_timer_") + dataset + "_" + odometry),
      "Error of the objects' " + what + " when registered, " + dataset + ", " + odometry +
          (timer ? ", the setup with timer" : ", the setups without timer"),
      "set xlabel 'time [s]'\nset ylabel '" + std::string(rotation ? "error [deg]" : "error [cm]") +
          "'\nset yrange [0:*]\n");
  int colour = 1;
  for (const SetupName& setup : setupNames()) {
    ++colour;
    if (setup.setup == "baseline" || (setup.setup == "full") != timer) continue;
    std::vector<const RunResult*> runs;
    for (const RunResult& r : results)
      if (r.key.dataset == dataset && r.key.odometry == odometry && r.key.setup == setup.setup)
        runs.push_back(&r);
    if (!runs.empty()) addErrorCurve(runs, rotation, setup.paper, colour, plot);
  }
  plots.push_back(plot);
}

Plot optimizationTime(const std::vector<RunResult>& results, const std::string& odometry) {
  Plot plot(fileName("optimization_time_" + odometry),
            "Time of one optimisation against the nodes of the graph, all datasets, " + odometry,
            "set xlabel 'nodes'\nset ylabel 'optimisation time [ms]'\nset yrange [0:*]\n");
  int colour = 0;
  for (const SetupName& setup : setupNames()) {
    ++colour;
    for (const RunResult& r : results) {
      if (r.key.odometry != odometry || r.key.setup != setup.setup) continue;
      const std::size_t step = std::max<std::size_t>(1, r.optimization_samples.size() / 150);
      for (std::size_t i = 0; i < r.optimization_samples.size(); i += step)
        plot.line({r.optimization_samples[i].nodes, r.optimization_samples[i].ms});
    }
    plot.curve(setup.paper,
               "with points pointtype 7 pointsize 0.3 linecolor " + std::to_string(colour));
  }
  return plot;
}

void addWalls(const fs::path& world_file, Plot& plot) {
  for (const auto& storey : simulation::readWorld(world_file).storeys) {
    for (const auto& wall : storey.walls) {
      std::vector<simulation::Door> doors = wall.doors;
      std::sort(doors.begin(), doors.end(),
                [](const auto& a, const auto& b) { return a.at_m < b.at_m; });
      const Vector2 along = (wall.to - wall.from).normalized();
      Vector2 from = wall.from;
      for (const auto& door : doors) {
        const Vector2 edge = wall.from + (door.at_m - 0.5 * door.width_m) * along;
        plot.line({from.x(), from.y()});
        plot.line({edge.x(), edge.y()});
        plot.gap();
        from = wall.from + (door.at_m + 0.5 * door.width_m) * along;
      }
      plot.line({from.x(), from.y()});
      plot.line({wall.to.x(), wall.to.y()});
      plot.gap();
    }
  }
  plot.curve("walls", "with lines linewidth 2 linecolor rgb '#808080'");
}

/// Objects where they were registered, and where they were; agents' ways.
void addEntities(const RunResult& run, Plot& plot) {
  std::map<int, std::vector<const EntitySample*>> tracks;
  for (const EntitySample& s : run.entity_samples) tracks[s.id].push_back(&s);
  for (const bool truth : {true, false}) {
    const std::size_t x = truth ? 2 : 0;
    for (const auto& [id, track] : tracks) {
      if (track.front()->semantic_class != "object") continue;
      for (const EntitySample* s : track) plot.line({s->place[x], s->place[x + 1]});
    }
    plot.curve(truth ? "objects, truth" : "objects",
               truth ? "with points pointtype 4 pointsize 0.9 linecolor rgb '#909090'"
                     : "with points pointtype 7 pointsize 0.3 linecolor rgb '#d95f02'");
    for (const auto& [id, track] : tracks) {
      if (track.front()->semantic_class == "object") continue;
      for (const EntitySample* s : track) plot.line({s->place[x], s->place[x + 1]});
      plot.gap();
    }
    plot.curve(
        truth ? "agents, truth" : "agents",
        truth ? "with linespoints pointtype 7 pointsize 0.3 linewidth 2 linecolor rgb '#d0d0e0'"
              : "with linespoints pointtype 7 pointsize 0.2 linewidth 0.7 linecolor rgb "
                "'#7570b3'");
  }
}

Plot mapFromAbove(const std::vector<RunResult>& results, const std::string& dataset,
                  const std::string& odometry, const std::map<std::string, fs::path>& worlds) {
  Plot plot(fileName("map_" + dataset + "_" + odometry),
            "Trajectories and entities from above, " + dataset + ", " + odometry + ", seed 1",
            "set xlabel 'x [m]'\nset ylabel 'y [m]'\nset size ratio -1\n");
  const auto world = worlds.find(dataset);
  if (world != worlds.end()) addWalls(world->second, plot);
  bool truth_drawn = false;
  const RunResult* with_entities = nullptr;
  int colour = 0;
  for (const SetupName& setup : setupNames()) {
    ++colour;
    for (const RunResult& r : results) {
      if (r.key.dataset != dataset || r.key.odometry != odometry || r.key.setup != setup.setup ||
          r.key.seed != 1)
        continue;
      if (!truth_drawn) {
        for (const auto& p : r.path) plot.line({p[2], p[3]});
        plot.curve("truth", "with lines linewidth 3 linecolor rgb '#c0c0c0'");
        truth_drawn = true;
      }
      if (!r.entity_samples.empty()) with_entities = &r;
      for (const auto& p : r.path) plot.line({p[0], p[1]});
      plot.curve(setup.paper, "with lines linewidth 1 linecolor " + std::to_string(colour));
    }
  }
  // Of the last setup that maps any.
  if (with_entities) addEntities(*with_entities, plot);
  return plot;
}

}  // namespace

std::vector<Figure> drawFigures(const std::vector<RunResult>& results,
                                const std::map<std::string, fs::path>& worlds,
                                const fs::path& folder) {
  std::error_code failure;
  fs::create_directories(folder, failure);
  if (failure) throw DataError(folder.string() + ": cannot be created: " + failure.message());
  std::vector<Plot> plots;
  const auto odometries = distinct(results, [](const RunResult& r) { return r.key.odometry; });
  const auto datasets = distinct(results, [](const RunResult& r) { return r.key.dataset; });
  for (const std::string& odometry : odometries)
    plots.push_back(optimizationTime(results, odometry));
  for (const std::string& dataset : datasets) {
    for (const std::string& odometry : odometries) {
      plots.push_back(mapFromAbove(results, dataset, odometry, worlds));
      for (const bool rotation : {false, true})
        for (const bool timer : {true, false})
          errorsOverTime(results, dataset, odometry, timer, rotation, plots);
    }
  }
  std::vector<Figure> figures;
  for (const Plot& plot : plots)
    if (!plot.empty()) figures.push_back(plot.draw(fs::absolute(folder)));
  return figures;
}

}  // namespace dynemo::experiments
