// A run of three keyframes, two entities and a floor, small enough to check by hand.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "dynemo/exporters/export_params.h"
#include "dynemo/exporters/run_result.h"

namespace dynemo::test {

struct SmallRun {
  CSceneGraph graph;
  std::vector<FramePose> frames;
  std::map<NodeId, Matrix6> covariances;

  RunResult result() const { return {graph, frames, covariances}; }
};

/// Node ids: 0, 1, 5 keyframes; 2 floor; 3, 6 observations of the box (moved in the second); 4 of a
/// walker. Keyframes 0 and 1 are connected twice, by odometry and by a loop closure in the opposite
/// direction.
SmallRun smallRun();

/// A folder of the running test's own, removed with the object.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

std::string readFile(const std::filesystem::path& file);

/// Runs an exporter by its name and returns the file's bytes; of a folder, all files' one after
/// the other, each after a line with its name.
std::string exported(const std::string& exporter, const RunResult& run,
                     const ExportParams& params = {});

}  // namespace dynemo::test
