// The recordings with ground truth that the programs are run on.
#pragma once

#include <mrpt/obs/CObservation.h>
#include <filesystem>
#include <functional>
#include <optional>
#include <set>
#include <string>

#include "dynemo/core/ids.h"

namespace dynemo::test {

namespace fs = std::filesystem;

/// NAME.rawlog, NAME_Images, NAME_entities.yaml and ground truth in one folder.
struct Dataset {
  fs::path folder;
  std::string name;

  fs::path rawlog() const { return folder / (name + ".rawlog"); }
  fs::path images() const { return folder / (name + "_Images"); }
  fs::path entities() const { return folder / (name + "_entities.yaml"); }
  fs::path truth() const { return folder / (name + "_gt_robot.tum"); }
  fs::path entityTruth() const { return folder / (name + "_gt_entities.csv"); }
};

/// rawlogs/rooms_agents of this project.
Dataset bundledSample();
/// rawlogs/hall: hand-held, simulated by this project.
Dataset hallSample();
/// A dataset of the folder that the environment variable DYNEMO_SAMPLES names; empty when unset.
std::optional<Dataset> sample(const std::string& name);

/// Objects that the ground truth displaces, of those with ground truth.
std::set<EntityId> displacedObjects(const Dataset& dataset);

using KeepObservation = std::function<bool(const mrpt::obs::CObservation&)>;
/// Copies a rawlog of observations, leaving out what `keep` refuses. Returns the number written.
std::size_t copyRawlog(const fs::path& from, const fs::path& to, const KeepObservation& keep,
                       bool compressed = true);
KeepObservation withoutLabels(const std::set<std::string>& labels);
/// The first seconds of the bundled sample.
KeepObservation firstSeconds(double seconds);

std::string readBytes(const fs::path& file);
void writeBytes(const fs::path& file, const std::string& bytes);

/// A folder of its own, removed at the end.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const fs::path& path() const { return path_; }
  fs::path operator/(const std::string& name) const { return path_ / name; }

 private:
  fs::path path_;
};

}  // namespace dynemo::test
