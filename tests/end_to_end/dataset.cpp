#include "dataset.h"

#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/maps/registerAllClasses.h>
#include <mrpt/obs/registerAllClasses.h>
#include <mrpt/serialization/CArchive.h>

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "dynemo/core/mrpt_conversions.h"
#include "dynemo/evaluation/entity_data.h"

namespace dynemo::test {

Dataset bundledSample() {
  return {fs::path(DYNEMO_SOURCE_DIR) / "rawlogs" / "rooms_agents", "rooms_agents"};
}

Dataset hallSample() { return {fs::path(DYNEMO_SOURCE_DIR) / "rawlogs" / "hall", "hall"}; }

std::optional<Dataset> sample(const std::string& name) {
  const char* folder = std::getenv("DYNEMO_SAMPLES");
  if (folder == nullptr || *folder == '\0') return std::nullopt;
  return Dataset{fs::path(folder) / name, name};
}

std::set<EntityId> displacedObjects(const Dataset& dataset) {
  constexpr double kDisplaced_m = 0.1;
  std::set<EntityId> displaced;
  for (const auto& [id, truth] : readEntityTruths(dataset.entityTruth())) {
    const Vector3 motion = truth.poses.back().T.t - truth.poses.front().T.t;
    if (truth.semantic_class == SemanticClass::kObject && motion.norm() > kDisplaced_m)
      displaced.insert(id);
  }
  return displaced;
}

std::size_t copyRawlog(const fs::path& from, const fs::path& to, const KeepObservation& keep,
                       bool compressed) {
  mrpt::obs::registerAllClasses_mrpt_obs();
  mrpt::maps::registerAllClasses_mrpt_maps();
  mrpt::io::CFileGZInputStream in(from.string());
  mrpt::io::CFileGZOutputStream out;
  if (!out.open(to.string(), compressed ? 1 : 0)) throw std::runtime_error(to.string());
  auto source = mrpt::serialization::archiveFrom(in);
  auto sink = mrpt::serialization::archiveFrom(out);
  std::size_t written = 0;
  try {
    while (true) {
      const auto object = source.ReadObject<mrpt::obs::CObservation>();
      if (!keep(*object)) continue;
      sink << *object;
      ++written;
    }
  } catch (const mrpt::serialization::CExceptionEOF&) {
  }
  return written;
}

KeepObservation withoutLabels(const std::set<std::string>& labels) {
  return [labels](const mrpt::obs::CObservation& o) { return !labels.contains(o.sensorLabel); };
}

KeepObservation firstSeconds(double seconds) {
  const Stamp begin = readTum(bundledSample().truth()).front().stamp;
  return [=](const mrpt::obs::CObservation& o) {
    return secondsBetween(begin, fromMrpt(o.timestamp)) < seconds;
  };
}

std::string readBytes(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw std::runtime_error(file.string() + ": cannot be read");
  std::ostringstream bytes;
  bytes << in.rdbuf();
  return bytes.str();
}

void writeBytes(const fs::path& file, const std::string& bytes) {
  std::ofstream out(file, std::ios::binary);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!out) throw std::runtime_error(file.string() + ": cannot be written");
}

TemporaryFolder::TemporaryFolder() {
  std::string name = (fs::temp_directory_path() / "dynemo_end_to_end_XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error(name + ": cannot be created");
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

}  // namespace dynemo::test
