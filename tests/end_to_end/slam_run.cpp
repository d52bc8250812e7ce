#include "slam_run.h"

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <sstream>

namespace dynemo::test {

Outcome slam(const Arguments& arguments, const fs::path& working_folder,
             std::chrono::seconds limit) {
  Arguments command = {DYNEMO_SLAM};
  command.insert(command.end(), arguments.begin(), arguments.end());
  return runCommand(command, working_folder, limit);
}

Arguments slamCommand(const Dataset& dataset, const fs::path& output, const Arguments& more) {
  Arguments arguments = {"--entities", dataset.entities(), "--output", output, dataset.rawlog()};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

SlamRun::SlamRun(const Dataset& dataset, const Arguments& more)
    : dataset_(dataset),
      folder_(temporary_ / "run"),
      outcome_(slam(slamCommand(dataset, folder_, more))) {}

nlohmann::json SlamRun::summary() const { return readJson(folder_ / "summary.json"); }

std::size_t SlamRun::edges(const std::string& kind) const {
  return summary().at("graph").at("edges").value(kind, std::size_t{0});
}

std::size_t SlamRun::nodes(const std::string& kind) const {
  return summary().at("graph").at("nodes").value(kind, std::size_t{0});
}

std::set<EntityId> SlamRun::movedObjects() const {
  std::set<EntityId> moved;
  const nlohmann::json all = summary();
  for (const auto& entity : all.at("entities")) {
    if (entity.at("class") == "object" && entity.at("moved") == true)
      moved.insert({entity.at("id").get<std::int64_t>()});
  }
  return moved;
}

nlohmann::json SlamRun::evaluate() const {
  const fs::path json = temporary_ / "evaluation.json";
  const Outcome outcome =
      runCommand({DYNEMO_EVAL, "--reference", dataset_.truth(), "--entities-reference",
                  dataset_.entityTruth(), "--json", json, folder_});
  if (outcome.status != 0) throw std::runtime_error("dynemo-eval: " + describe(outcome));
  return readJson(json);
}

const SlamRun& bundledRun(const std::string& setup) {
  static std::map<std::string, std::unique_ptr<SlamRun>> runs;
  auto& run = runs[setup];
  if (!run) {
    run = std::make_unique<SlamRun>(bundledSample(), Arguments{"--setup", setup});
    EXPECT_TRUE(run->ok()) << setup << ": " << describe(run->outcome());
  }
  return *run;
}

double ate(const nlohmann::json& evaluation, const std::string& part) {
  return evaluation.at(part).at("ate_m").at("rmse").get<double>();
}

nlohmann::json readJson(const fs::path& file) { return nlohmann::json::parse(readBytes(file)); }

void expectRefusal(const Outcome& outcome, int status, const std::vector<std::string>& parts) {
  SCOPED_TRACE(describe(outcome));
  EXPECT_EQ(outcome.status, status);
  EXPECT_EQ(outcome.signal, 0);
  EXPECT_TRUE(outcome.out.empty());
  EXPECT_EQ(outcome.err.rfind("dynemo-slam: ", 0), 0u);
  std::size_t messages = 0;
  std::istringstream lines(outcome.err);
  for (std::string line; std::getline(lines, line);) {
    // A message that lists several problems indents them.
    messages += line.rfind("  ", 0) != 0;
  }
  EXPECT_EQ(messages, 1u);
  for (const std::string& part : parts) {
    EXPECT_NE(outcome.err.find(part), std::string::npos) << part;
  }
}

std::uint64_t warningCount(const nlohmann::json& summary, const std::string& text) {
  std::uint64_t count = 0;
  for (const auto& [warning, times] : summary.at("warnings").items()) {
    if (warning.find(text) != std::string::npos) count += times.get<std::uint64_t>();
  }
  return count;
}

}  // namespace dynemo::test
