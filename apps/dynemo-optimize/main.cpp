// dynemo-optimize: the back-end on its own, for SE(3) pose graphs in g2o's and MRPT's text formats.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <sstream>
#include <string>

#include "../common/program.h"
#include "dynemo/backend/chordal_initialization.h"
#include "dynemo/backend/g2o_io.h"
#include "dynemo/backend/optimizer.h"
#include "dynemo/core/output_file.h"

namespace {

using namespace dynemo;

struct Options {
  std::string graph, output, initial = "auto";
  bool repair = false;
  SolverParams solver{.method = SolverParams::Method::kBatch};
};

void declare(CLI::App& app, Options& options) {
  app.set_version_flag("--version", std::string("dynemo-optimize ") + DYNEMO_VERSION);
  app.add_option("graph", options.graph, "Pose graph: g2o (SE3:QUAT records) or MRPT (.graph)")
      ->required()
      ->type_name("GRAPH");
  app.add_option("-o,--output", options.output,
                 "Write the graph with its optimised poses to this file, in the format it has")
      ->type_name("FILE");
  app.add_option("--initial", options.initial,
                 "Poses to start from: the file's, the chordal relaxation's, or whichever of the "
                 "two has the lower cost")
      ->check(CLI::IsMember({"auto", "file", "chordal"}))
      ->capture_default_str();
  app.add_flag("--repair", options.repair,
               "Repair information matrices that are not positive definite instead of refusing "
               "the file");
  app.add_option("--max-iterations", options.solver.max_iterations, "Most accepted steps")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  app.add_option("--min-relative-decrease", options.solver.min_relative_decrease,
                 "Stop when a step lowers the cost by less than this fraction")
      ->check(CLI::Range(0.0, 0.1))
      ->capture_default_str();
  app.footer(
      "The cost is F = ½ Σ eᵀΩe, half of g2o's chi2, with g2o's own residual for its edges. Poses "
      "keep the place of the first fixed vertex, or of the first one.\nExit status: 0 ok, 2 usage, "
      "3 data, 4 internal error.");
}

/// "auto" and "chordal" replace the poses; says what was chosen.
std::string chooseStart(CSceneGraph& graph, const std::string& initial) {
  if (initial == "file") return "the file's";
  std::vector<Pose3> T_file;
  for (const auto& keyframe : graph.keyframes()) T_file.push_back(keyframe->T_map_node);
  const double file_cost = graph.totalCost();
  const auto solved = initializeChordal(graph);
  if (!solved && initial == "chordal") throw DataError(solved.error());
  const double chordal_cost = graph.totalCost();
  const std::string costs =
      " (F = " + exactNumber(chordal_cost) + "; the file's " + exactNumber(file_cost) + ")";
  if (solved && (initial == "chordal" || chordal_cost < file_cost)) return "chordal" + costs;
  for (std::size_t i = 0; i < T_file.size(); ++i) graph.keyframes()[i]->T_map_node = T_file[i];
  return "the file's (F = " + exactNumber(file_cost) + ")";
}

/// A relative measurement moves with the whole graph: the anchor goes back to where the file has
/// it.
void restoreAnchor(CSceneGraph& graph, const Pose3& T_map_anchor) {
  const Pose3 T_map_moved = T_map_anchor * graph.keyframes().front()->T_map_node.inverse();
  for (const auto& keyframe : graph.keyframes())
    if (!graph.edgesOf(keyframe->id).empty())
      keyframe->T_map_node = (T_map_moved * keyframe->T_map_node).normalized();
}

void writeResult(const Options& options, const std::string& original, const G2oContents& contents) {
  std::istringstream in(original);
  std::ostringstream text;
  rewriteG2o(in, options.graph, contents, text);
  writeFileAtomically(options.output, text.str());
}

double secondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// All of it at once: a pipe can be read only once.
std::string readText(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  if (!in) throw DataError(file + ": cannot be read");
  return text;
}

int optimize(const Options& options) {
  G2oReadOptions reading;
  reading.residual = G2oReadOptions::Residual::kG2o;
  if (options.repair) reading.indefinite = G2oReadOptions::Indefinite::kRepair;
  const std::string text = readText(options.graph);
  std::istringstream in(text);
  G2oContents contents = readG2o(in, options.graph, reading);
  CSceneGraph& graph = contents.graph;
  if (contents.relative_edges == 0) throw DataError(options.graph + ": holds no edge");

  if (!options.output.empty()) prepareFolderOf(options.output);
  const Pose3 T_map_anchor = graph.keyframes().front()->T_map_node;
  const auto start = std::chrono::steady_clock::now();
  const std::string chosen = chooseStart(graph, options.initial);
  const double start_s = secondsSince(start);
  const OptimizationReport report = Optimizer(options.solver).optimizeFully(graph);
  if (!report.usable()) throw DataError(options.graph + ": " + report.message);
  const double total_s = secondsSince(start);
  if (!contents.fixed) restoreAnchor(graph, T_map_anchor);

  std::printf("graph       %zu vertices, %zu edges\n", contents.node_of_vertex.size(),
              contents.relative_edges);
  if (contents.repaired_edges > 0)
    std::printf("repaired    %zu information matrices\n", contents.repaired_edges);
  std::printf("start       %s\n", chosen.c_str());
  std::printf("cost        %.6f -> %.6f (chi2 %.6f)\n", report.cost_before, report.cost_after,
              2.0 * report.cost_after);
  std::printf("steps       %d, %s\n", report.iterations, stopReasonName(report.stop));
  std::printf("time        %.3f s, of which the start took %.3f s\n", total_s, start_s);
  if (std::fflush(stdout) != 0) throw DataError("standard output: cannot be written");
  if (!options.output.empty()) writeResult(options, text, contents);
  return static_cast<int>(ExitStatus::kOk);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Optimises an SE(3) pose graph.", "dynemo-optimize");
  declare(app, options);
  return runProgram(app, argc, argv, [&options] { return optimize(options); });
}
