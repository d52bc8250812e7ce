// The true half of a dataset.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "dynemo/core/time.h"
#include "dynemo/simulation/scene.h"
#include "dynemo/simulation/simulation.h"
#include "recording.h"

namespace dynemo::simulation {

/// A text file that has a temporary name until finish().
class GrowingFile {
 public:
  GrowingFile(std::filesystem::path file, const std::string& header);
  ~GrowingFile();
  GrowingFile(const GrowingFile&) = delete;
  GrowingFile& operator=(const GrowingFile&) = delete;
  void write(const char* text) { out_ << text; }
  void finish();

 private:
  std::filesystem::path file_, temporary_;
  std::ofstream out_;
  bool finished_ = false;
};

/// NAME_gt_robot.tum: T_world_base at every stamp of a sensor and every 10 ms.
class RobotTruth {
 public:
  RobotTruth(const Scene& scene, const std::filesystem::path& folder);
  /// Writes all that lies before, and the reading's own time. Times must not descend.
  void upTo(std::int64_t t_us);
  void finish() { file_.finish(); }

 private:
  void write(std::int64_t t_us);
  const Scene& scene_;
  GrowingFile file_;
  std::int64_t grid_us_ = 0, last_us_ = -1;
};

/// NAME_gt_entities.csv: T_world_entity. Agents every 100 ms; objects at the start, around each
/// change and at the end, every 100 ms while they slide. Linear interpolation between the rows of
/// one entity is right.
class EntityTruth {
 public:
  EntityTruth(const Scene& scene, const std::filesystem::path& folder);
  void upTo(std::int64_t t_us);
  void finish(std::int64_t end_us);

 private:
  void write(std::size_t entity, std::int64_t t_us);
  void writeObject(std::size_t entity, std::int64_t t_us);
  const Scene& scene_;
  GrowingFile file_;
  std::int64_t grid_us_ = 0;
};

/// NAME_meta.json: the truth about planes, floors, relocations, extrinsics and noise.
std::string metaJson(const Scene& scene, const SimulationCounts& counts);

}  // namespace dynemo::simulation
