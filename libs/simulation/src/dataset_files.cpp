#include "dataset_files.h"

#include <mrpt/serialization/CArchive.h>

#include <cstdio>
#include <fstream>
#include <numbers>
#include <sstream>

#include "dynemo/core/error.h"
#include "dynemo/core/output_file.h"
#include "dynemo/simulation/solids.h"

namespace dynemo::simulation {
namespace {

namespace fs = std::filesystem;

/// Fast: scans of rounded coordinates gain little from more effort.
constexpr int kCompression = 1;

std::string formatted(const char* format, auto... values) {
  char text[256];
  std::snprintf(text, sizeof(text), format, values...);
  return text;
}

std::array<Vector3, 4> corners(const TagSheet& tag) {
  const double h = 0.5 * tag.size_m;
  return {tag.T_body_tag * Vector3(-h, h, 0), tag.T_body_tag * Vector3(h, h, 0),
          tag.T_body_tag * Vector3(h, -h, 0), tag.T_body_tag * Vector3(-h, -h, 0)};
}

std::string tagYaml(const TagSheet& tag) {
  const Eigen::Quaterniond q = tag.T_body_tag.quaternion();
  const Vector3& t = tag.T_body_tag.t;
  std::string text = formatted(
      "      - {id: %d, size: %.4f, side: %s, pose: [%.6f, %.6f, %.6f, %.9f, %.9f, %.9f, %.9f], "
      "corners: [",
      tag.tag_id, tag.size_m, tag.side.c_str(), t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
  bool first = true;
  for (const Vector3& c : corners(tag)) {
    text += formatted(first ? "[%.5f, %.5f, %.5f]" : ", [%.5f, %.5f, %.5f]", c.x(), c.y(), c.z());
    first = false;
  }
  return text + "]}\n";
}

}  // namespace

RawlogWriter::RawlogWriter(const fs::path& folder, const std::string& name)
    : rawlog_(folder / (name + ".rawlog")),
      temporary_(folder / (name + ".rawlog.part")),
      images_(folder / (name + "_Images")) {
  std::error_code failure;
  fs::remove_all(images_, failure);
  fs::create_directories(images_, failure);
  if (failure) throw DataError(images_.string() + ": cannot be created: " + failure.message());
  if (!out_.open(temporary_.string(), kCompression))
    throw DataError(temporary_.string() + ": cannot be written");
}

RawlogWriter::~RawlogWriter() {
  if (finished_) return;
  out_.close();
  std::error_code ignored;
  fs::remove(temporary_, ignored);
}

void RawlogWriter::write(const Reading& reading) {
  if (!reading.image_file.empty()) {
    const fs::path file = images_ / reading.image_file;
    std::ofstream image(file, std::ios::binary);
    image.write(reinterpret_cast<const char*>(reading.image_bytes.data()),
                static_cast<std::streamsize>(reading.image_bytes.size()));
    image.close();
    if (!image) throw DataError(file.string() + ": cannot be written");
  }
  try {
    auto archive = mrpt::serialization::archiveFrom(out_);
    archive << *reading.observation;
  } catch (const std::exception&) {
    throw DataError(temporary_.string() + ": cannot be written");
  }
}

void RawlogWriter::finish() {
  out_.close();
  std::error_code failure;
  fs::rename(temporary_, rawlog_, failure);
  if (failure) throw DataError(rawlog_.string() + ": cannot be written: " + failure.message());
  finished_ = true;
}

std::string entityYaml(const World& world) {
  std::string text =
      "# Which tag sits where on which entity; no poses. 'pose' is T_entity_tag: x y z qx qy qz "
      "qw.\n"
      "tag_family: tag36h11\nentities:";
  if (world.entities.empty()) return text + " []\n";
  text += "\n";
  for (const Entity& entity : world.entities) {
    text += formatted("  - id: %d\n    class: %s\n    model: %s\n    origin_z: ", entity.id,
                      entity.isAgent() ? "agent" : "object", entity.model.c_str());
    text += exactNumber(originHeight(entity)) + "\n";
    if (entity.isAgent()) text += "    prior_direction: [1, 0, 0]\n";
    text += "    tags:\n";
    for (const TagSheet& tag : entityBody(entity).tags) text += tagYaml(tag);
  }
  return text;
}

std::string slamConfigYaml(const World& world) {
  const LidarSpec& lidar = world.sensors.lidar;
  std::string text =
      "# For dynemo-slam --config: what the rawlog does not tell about its sensors.\n";
  text += "sensors:\n  lidar:\n    min_range_m: " + exactNumber(lidar.min_range_m) + "\n";
  if (lidar.motion_distortion && !lidar.rotating_scan)
    text += "    sweep_rate_hz: " + exactNumber(lidar.rate_hz) + "\n";
  if (lidar.rotating_scan) {
    text += "    elevations_deg: [";
    for (int ring = 0; ring < lidar.rings; ++ring) {
      text += (ring == 0 ? "" : ", ") +
              exactNumber(lidar.elevation_rad(ring) * 180.0 / std::numbers::pi);
    }
    text += "]\n";
  }
  return text;
}

}  // namespace dynemo::simulation
