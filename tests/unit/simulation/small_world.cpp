#include "small_world.h"

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "dynemo/simulation/world_file.h"

namespace dynemo::simulation::test {

std::string smallWorldYaml() {
  return R"(name: small
seed: 3
duration_s: 4
storeys:
  - name: ground
    outline: [0, 0, 8, 5]
    floor_z: 0
    ceiling_z: 2.7
    walls:
      - {from: [0, 0], to: [8, 0]}
      - {from: [8, 0], to: [8, 5]}
      - {from: [8, 5], to: [0, 5]}
      - {from: [0, 5], to: [0, 0]}
      - {from: [5, 0], to: [5, 5], doors: [{at: 2.5, width: 1.0, height: 2.1}]}
    furniture:
      - {model: table, at: [2.5, 4.5], yaw_deg: 180, size: [1.2, 0.6, 0.75]}
      - {model: shelf, at: [7.7, 1.0], yaw_deg: 90, size: [1.0, 0.3, 1.8]}
entities:
  - {id: 1, model: box, at: [3.5, 1.0], yaw_deg: 20, size: [0.5, 0.5, 0.5], tags: [0, 1, 2, 3]}
  - {id: 2, model: chair, at: [7.0, 4.0], yaw_deg: 200, tags: [4, 5, 6, 7]}
  - {id: 101, model: human, path: {from: [3.9, 3.2], to: [3.9, 4.2], speed: 0.6, turn_s: 1, phase_s: 0.4}, tags: [8, 9, 10, 11]}
relocations:
  - {entity: 1, time_s: 2.05, to: [4.2, 0.8], yaw_deg: 110}
  - {entity: 2, time_s: 1.0, duration_s: 1.5, to: [6.5, 4.0], yaw_deg: 260}
robot:
  carrier: wheels
  speed: 0.8
  route:
    - {at: [1.0, 2.5]}
    - {at: [6.0, 2.5], wait_s: 0.5}
    - {at: [6.0, 1.2]}
sensors:
  lidar: {rings: 16, columns: 256, rate_hz: 5}
  camera: {width: 640, height: 480, fx: 460, fy: 459.2, cx: 323.4, cy: 236.7, rate_hz: 5}
)";
}

World smallWorld() { return parseWorld(smallWorldYaml(), "small world"); }

std::string changed(const std::string& part, const std::string& by) {
  std::string text = smallWorldYaml();
  const auto at = text.find(part);
  if (at == std::string::npos || text.find(part, at + 1) != std::string::npos)
    throw std::logic_error("'" + part + "' is not there exactly once");
  return text.replace(at, part.size(), by);
}

TemporaryFolder::TemporaryFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "dynemo_simulation_XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error(name + ": cannot be created");
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::string readBytes(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw std::runtime_error(file.string() + ": cannot be read");
  std::ostringstream bytes;
  bytes << in.rdbuf();
  return bytes.str();
}

}  // namespace dynemo::simulation::test
