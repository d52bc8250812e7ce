// Ray casting by Embree against the static world and moving rigid bodies.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "dynemo/core/se3.h"
#include "dynemo/simulation/solids.h"

namespace dynemo::simulation {

struct Ray {
  Eigen::Vector3f origin;     ///< world frame
  Eigen::Vector3f direction;  ///< unit vector
  float time = 0.0f;          ///< 0 at the beginning of the snapshot, 1 at its end
};

struct Hit {
  float range_m = 0.0f;  ///< infinite when nothing is hit
  std::uint32_t surface = 0;
};

/// One face of a box, or a tag's sheet: a rectangle.
struct Surface {
  std::size_t body = 0;  ///< 0: the static world
  Pose3 T_body_surface;  ///< origin in the middle, x and y along the sides, z outwards
  Vector2 half = Vector2::Zero();
  Colour colour = Colour::Zero();
  Texture texture = Texture::kPlain;
  const TagSheet* tag = nullptr;  ///< its frame has y and z turned: x right, y down, z inwards
};

/// The geometry of all bodies, ready for ray casting; shared by all threads. The bodies must
/// outlive it.
class RayCaster {
 public:
  /// Body 0 is the static world, in the world frame.
  explicit RayCaster(const std::vector<Body>& bodies);
  ~RayCaster();

  const std::vector<Surface>& surfaces() const;

  /// The bodies at their places during a short time; for one thread.
  class Snapshot {
   public:
    explicit Snapshot(const RayCaster& caster);
    ~Snapshot();
    Snapshot(const Snapshot&) = delete;
    Snapshot& operator=(const Snapshot&) = delete;

    /// T_world_body of body 1, 2, … at one or more instants, evenly spaced from time 0 to 1; in
    /// between the bodies move straight and turn steadily.
    void place(std::span<const std::vector<Pose3>> instants);
    /// `hits` is as long as `rays`. Rays that follow each other should be close together.
    void cast(std::span<const Ray> rays, std::span<Hit> hits) const;

   private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
  };

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace dynemo::simulation
