#include "truth_files.h"

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <numbers>

#include "dynemo/core/config.h"
#include "dynemo/core/error.h"
#include "dynemo/simulation/collisions.h"
#include "dynemo/simulation/odometry.h"

namespace dynemo::simulation {
namespace {

using nlohmann::json;

constexpr std::int64_t kRobotGrid_us = 10'000, kEntityGrid_us = 100'000;

std::int64_t microseconds(double t_s) { return std::llround(t_s * 1e6); }

std::string stampText(const World& world, std::int64_t t_us) {
  const std::int64_t us = startStamp(world.seed).ns / 1000 + t_us;
  char text[32];
  std::snprintf(text, sizeof(text), "%lld.%06lld", static_cast<long long>(us / 1'000'000),
                static_cast<long long>(us % 1'000'000));
  return text;
}

json poseJson(const Pose3& T) {
  const Eigen::Quaterniond q = T.quaternion();
  return {T.t.x(), T.t.y(), T.t.z(), q.x(), q.y(), q.z(), q.w()};
}

json vectorJson(const Vector3& v) { return {v.x(), v.y(), v.z()}; }
json rectJson(const Rect& r) { return {r.x_min, r.y_min, r.x_max, r.y_max}; }

json planesJson(const World& world) {
  json planes = json::array();
  for (const TruePlane& plane : truePlanes(world))
    planes.push_back({{"name", plane.name},
                      {"n", vectorJson(plane.normal)},
                      {"d", plane.d},
                      {"storey", plane.storey}});
  return planes;
}

json floorsJson(const World& world) {
  json floors = json::array();
  for (const Storey& storey : world.storeys)
    floors.push_back({{"name", storey.name},
                      {"floor_z", storey.floor_z_m},
                      {"ceiling_z", storey.ceiling_z_m},
                      {"outline", rectJson(storey.outline)}});
  return floors;
}

/// Whether the camera has the point in view.
bool inCameraView(const Scene& scene, const std::vector<Footprint>& solids, const Vector3& p,
                  double t_s) {
  const CameraSpec& camera = scene.world().sensors.camera;
  const Pose3 T_world_camera = scene.robot().at(t_s) * T_base_camera(camera);
  const Vector3 q = T_world_camera.inverse() * p;
  const double u = camera.fx * q.x() / q.z() + camera.cx, v = camera.fy * q.y() / q.z() + camera.cy;
  return q.z() > 0 && u >= 0 && u < camera.width && v >= 0 && v < camera.height &&
         !isBlocked(solids, T_world_camera.t, p);
}

json relocationsJson(const Scene& scene) {
  json list = json::array();
  const std::vector<Footprint> solids = obstacles(scene.world());
  for (std::size_t i = 0; i < scene.entities().size(); ++i) {
    const auto& placements = scene.entities()[i].placements();
    for (std::size_t k = 1; k < placements.size(); ++k) {
      const auto& now = placements[k];
      if (now.time_s > scene.world().duration_s) continue;
      const Pose3 T_before = scene.entities()[i].at(now.time_s - 1e-6);
      const Pose3 T_after = scene.entities()[i].at(now.time_s + now.duration_s);
      const Vector3 p_lidar =
          (scene.robot().at(now.time_s) * T_base_lidar(scene.world().sensors.lidar)).t;
      list.push_back(
          {{"entity_id", scene.world().entities[i].id},
           {"timestamp", stampText(scene.world(), microseconds(now.time_s))},
           {"t_rel", now.time_s},
           {"duration", now.duration_s},
           {"displacement_m", (T_after.t - T_before.t).norm()},
           {"rotation_deg", rotationAngle(T_before.inverse() * T_after) * 180.0 / std::numbers::pi},
           {"pose", poseJson(T_after)},
           {"in_camera_view", inCameraView(scene, solids, T_before.t, now.time_s) ||
                                  inCameraView(scene, solids, T_after.t, now.time_s)},
           {"lidar_line_of_sight",
            !isBlocked(solids, p_lidar, T_before.t) || !isBlocked(solids, p_lidar, T_after.t)}});
    }
  }
  return list;
}

json entitiesJson(const Scene& scene) {
  json list = json::array();
  for (std::size_t i = 0; i < scene.world().entities.size(); ++i) {
    const Entity& entity = scene.world().entities[i];
    const auto [low, high] = bounds(scene.bodies()[i + 1]);
    json item{{"id", entity.id},
              {"class", entity.isAgent() ? "agent" : "object"},
              {"model", entity.model},
              {"origin_z", originHeight(entity)},
              {"bbox_entity_frame", {vectorJson(low), vectorJson(high)}}};
    if (entity.path) {
      const Vector2 along = (entity.path->to - entity.path->from).normalized();
      item["line_direction_world"] = {along.x(), along.y(), 0.0};
      item["path"] = {{"a", {entity.path->from.x(), entity.path->from.y()}},
                      {"b", {entity.path->to.x(), entity.path->to.y()}},
                      {"speed", entity.path->speed_m_s},
                      {"turn_time", entity.path->turn_s},
                      {"phase", entity.path->phase_s}};
    }
    list.push_back(item);
  }
  return list;
}

}  // namespace

GrowingFile::GrowingFile(std::filesystem::path file, const std::string& header)
    : file_(std::move(file)), temporary_(file_.string() + ".part"), out_(temporary_) {
  if (!out_) throw DataError(temporary_.string() + ": cannot be written");
  out_ << header;
}

GrowingFile::~GrowingFile() {
  if (finished_) return;
  out_.close();
  std::error_code ignored;
  std::filesystem::remove(temporary_, ignored);
}

void GrowingFile::finish() {
  out_.close();
  std::error_code failure;
  if (out_) std::filesystem::rename(temporary_, file_, failure);
  if (!out_ || failure) throw DataError(file_.string() + ": cannot be written");
  finished_ = true;
}

RobotTruth::RobotTruth(const Scene& scene, const std::filesystem::path& folder)
    : scene_(scene),
      file_(folder / (scene.world().name + "_gt_robot.tum"),
            "# timestamp tx ty tz qx qy qz qw   (T_world_base: pose of base_link in the world)\n") {
}

void RobotTruth::write(std::int64_t t_us) {
  if (t_us == last_us_) return;
  last_us_ = t_us;
  const Pose3 T = scene_.robot().at(static_cast<double>(t_us) * 1e-6);
  const Eigen::Quaterniond q = T.quaternion();
  char line[192];
  std::snprintf(line, sizeof(line), "%s %.7f %.7f %.7f %.9f %.9f %.9f %.9f\n",
                stampText(scene_.world(), t_us).c_str(), T.t.x(), T.t.y(), T.t.z(), q.x(), q.y(),
                q.z(), q.w());
  file_.write(line);
}

void RobotTruth::upTo(std::int64_t t_us) {
  for (; grid_us_ <= t_us; grid_us_ += kRobotGrid_us) write(grid_us_);
  write(t_us);
}

EntityTruth::EntityTruth(const Scene& scene, const std::filesystem::path& folder)
    : scene_(scene),
      file_(folder / (scene.world().name + "_gt_entities.csv"),
            "entity_id,class,timestamp,x,y,z,qx,qy,qz,qw\n") {}

void EntityTruth::write(std::size_t entity, std::int64_t t_us) {
  const Pose3 T = scene_.entities()[entity].at(static_cast<double>(t_us) * 1e-6);
  const Eigen::Quaterniond q = T.quaternion();
  const Entity& e = scene_.world().entities[entity];
  char line[192];
  std::snprintf(line, sizeof(line), "%d,%s,%s,%.6f,%.6f,%.6f,%.8f,%.8f,%.8f,%.8f\n", e.id,
                e.isAgent() ? "agent" : "object", stampText(scene_.world(), t_us).c_str(), T.t.x(),
                T.t.y(), T.t.z(), q.x(), q.y(), q.z(), q.w());
  file_.write(line);
}

/// An object's rows in the grid interval that begins at t_us.
void EntityTruth::writeObject(std::size_t entity, std::int64_t t_us) {
  if (t_us == 0) write(entity, 0);
  std::int64_t last_us = t_us - 1;
  const auto writeOnce = [&](std::int64_t at_us) {
    if (at_us <= last_us || at_us < t_us || at_us >= t_us + kEntityGrid_us || at_us <= 0) return;
    last_us = at_us;
    write(entity, at_us);
  };
  for (const auto& placement : scene_.entities()[entity].placements()) {
    const std::int64_t begin_us = microseconds(placement.time_s);
    const std::int64_t end_us = begin_us + microseconds(placement.duration_s);
    if (begin_us > t_us + 2 * kEntityGrid_us || end_us < t_us - 1) continue;
    if (placement.duration_s == 0.0) {
      writeOnce(begin_us - 1);
      writeOnce(begin_us);
    } else {
      writeOnce(begin_us);
      if (t_us > begin_us && t_us < end_us) writeOnce(t_us);
      writeOnce(end_us);
    }
  }
}

void EntityTruth::upTo(std::int64_t t_us) {
  for (; grid_us_ <= t_us; grid_us_ += kEntityGrid_us) {
    for (std::size_t i = 0; i < scene_.entities().size(); ++i) {
      if (scene_.entities()[i].isAgent())
        write(i, grid_us_);
      else
        writeObject(i, grid_us_);
    }
  }
}

void EntityTruth::finish(std::int64_t end_us) {
  upTo(end_us);
  for (std::size_t i = 0; i < scene_.entities().size(); ++i) {
    if (!scene_.entities()[i].isAgent() || end_us % kEntityGrid_us != 0) write(i, end_us);
  }
  file_.finish();
}

std::string metaJson(const Scene& scene, const SimulationCounts& counts) {
  const World& world = scene.world();
  double area_m2 = 0.0;
  for (const Storey& storey : world.storeys) area_m2 += storey.outline.area();
  json meta{
      {"name", world.name},
      {"seed", world.seed},
      {"duration_s", world.duration_s},
      {"t0_unix", startStamp(world.seed).ns / 1'000'000'000},
      {"area_m2", area_m2},
      {"path_length_m", scene.robot().distance(world.duration_s)},
      {"explore_end_s", scene.robot().lap_s()},
      {"pose_convention", "[x,y,z,qx,qy,qz,qw]; T_a_b maps b coordinates into a"},
      {"planes_convention", "n.p + d = 0 in the world frame, n points to the free side"},
      {"planes", planesJson(world)},
      {"floors", floorsJson(world)},
      {"relocations", relocationsJson(scene)},
      {"entities", entitiesJson(scene)},
      {"noise", world.sensors.noise},
      {"motion_distortion", world.sensors.lidar.motion_distortion},
      {"T_base_lidar", poseJson(T_base_lidar(world.sensors.lidar))},
      {"T_base_camera_optical", poseJson(T_base_camera(world.sensors.camera))},
      {"T_world_base_at_start", poseJson(scene.robot().at(0.0))},
      {"T_world_odom", poseJson(odometryOrigin(scene.robot()))},
      {"sensors", toYaml(world.sensors, false)},
      {"stats", {{"scans", counts.scans}, {"images", counts.images}, {"points", counts.points}}}};
  std::size_t agents = 0;
  for (const Entity& entity : world.entities) agents += entity.isAgent();
  meta["n_agents"] = agents;
  meta["n_objects"] = world.entities.size() - agents;
  return meta.dump(1) + "\n";
}

}  // namespace dynemo::simulation
