// The geometry of a world: everything is a box with six faces, and tags are sheets in front of
// faces.
#pragma once

#include <string>
#include <vector>

#include "dynemo/core/se3.h"
#include "dynemo/simulation/world.h"

namespace dynemo::simulation {

using Colour = Eigen::Vector3f;  ///< blue green red, 0 … 1

enum class Texture : std::uint8_t { kPlain, kWall, kTiles, kPanels };

struct Box {
  Pose3 T_body_box;
  Vector3 half = Vector3::Zero();  ///< half side lengths [m]
  Colour colour = Colour::Constant(0.6f);
  Texture texture = Texture::kPlain;
  std::string name;       ///< for messages and the truth about planes
  bool walkable = false;  ///< floors and ramps: no obstacle
};

/// Tag frame: libapriltag's (share/doc/conventions.md).
struct TagSheet {
  int tag_id = 0;
  double size_m = 0.0;  ///< side of the black square; the sheet has 10/8 of it
  std::string side;
  Pose3 T_body_tag;
};

/// A rigid thing: the static world, or one entity in its own frame.
struct Body {
  std::vector<Box> boxes;
  std::vector<TagSheet> tags;
};

/// Floors, ceilings, walls, furniture, ramps; in the world frame.
Body staticBody(const World& world);

/// In the entity's frame: x forward, y left, z up.
Body entityBody(const Entity& entity);

/// Height of the entity's origin over the floor [m].
double originHeight(const Entity& entity);

/// Corners of the box around the body in its own frame.
std::pair<Vector3, Vector3> bounds(const Body& body);

struct EntityModelInfo {
  std::string name;
  bool agent = false;
  bool sized = false;  ///< entities give their own size
  std::size_t tags = 4;
};
const std::vector<EntityModelInfo>& entityModels();
const EntityModelInfo* findEntityModel(const std::string& name);
std::vector<std::string> furnitureModels();

/// A flat piece of wall, floor or ceiling: n·p + d = 0 in the world, n towards the free side.
struct TruePlane {
  std::string name;
  Vector3 normal;
  double d = 0.0;
  std::string storey;
};
std::vector<TruePlane> truePlanes(const World& world);

}  // namespace dynemo::simulation
