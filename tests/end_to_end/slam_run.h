// One run of dynemo-slam and what it left.
#pragma once

#include <nlohmann/json.hpp>

#include "dataset.h"
#include "process.h"

namespace dynemo::test {

using Arguments = std::vector<std::string>;

/// dynemo-slam with these arguments.
Outcome slam(const Arguments& arguments, const fs::path& working_folder = {},
             std::chrono::seconds limit = kTimeLimit);
/// The command line of a run on a dataset with its entity file.
Arguments slamCommand(const Dataset& dataset, const fs::path& output, const Arguments& more = {});

/// A run on a dataset into a folder of its own.
class SlamRun {
 public:
  explicit SlamRun(const Dataset& dataset, const Arguments& more = {});

  const Outcome& outcome() const { return outcome_; }
  bool ok() const { return outcome_.status == 0; }
  const fs::path& folder() const { return folder_; }
  nlohmann::json summary() const;
  /// Number of edges of a kind in the summary.
  std::size_t edges(const std::string& kind) const;
  std::size_t nodes(const std::string& kind) const;
  /// Objects that the summary calls moved.
  std::set<EntityId> movedObjects() const;
  /// What dynemo-eval prints as JSON for this run.
  nlohmann::json evaluate() const;

 private:
  TemporaryFolder temporary_;
  Dataset dataset_;
  fs::path folder_;
  Outcome outcome_;
};

/// The run of a setup on the bundled sample; made once for all tests.
const SlamRun& bundledRun(const std::string& setup);

/// Root mean square of the trajectory errors in an evaluation [m]; `part`: trajectory, odometry.
double ate(const nlohmann::json& evaluation, const std::string& part = "trajectory");

nlohmann::json readJson(const fs::path& file);

/// Fails unless the program exited with the status after exactly one message that contains all the
/// parts, and printed nothing else.
void expectRefusal(const Outcome& outcome, int status, const std::vector<std::string>& parts);

/// How often the summary counts a warning that contains the text.
std::uint64_t warningCount(const nlohmann::json& summary, const std::string& text);

}  // namespace dynemo::test
