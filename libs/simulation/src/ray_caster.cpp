#include "dynemo/simulation/ray_caster.h"

#include <embree3/rtcore.h>

#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace dynemo::simulation {
namespace {

constexpr std::size_t kPacket = 8;

/// Closes what it opened.
template <class Handle, void (*release)(Handle)>
class Owned {
 public:
  explicit Owned(Handle handle) : handle_(handle) {
    if (handle == nullptr) throw std::runtime_error("Embree cannot be initialised");
  }
  ~Owned() { release(handle_); }
  Owned(const Owned&) = delete;
  Owned& operator=(const Owned&) = delete;
  Handle get() const { return handle_; }

 private:
  Handle handle_;
};

using Device = Owned<RTCDevice, rtcReleaseDevice>;
using Scene = Owned<RTCScene, rtcReleaseScene>;

/// x, y, z of face i outwards.
Matrix3 faceAxes(int face) {
  const int axis = face / 2;
  const double sign = face % 2 == 0 ? 1.0 : -1.0;
  Matrix3 R;
  R.col(2) = sign * Vector3::Unit(axis);
  R.col(0) = Vector3::Unit((axis + 1) % 3);
  R.col(1) = R.col(2).cross(R.col(0));
  return R;
}

void addFaces(const Box& box, std::size_t body, std::vector<Surface>& surfaces) {
  for (int face = 0; face < 6; ++face) {
    const Matrix3 R = faceAxes(face);
    Surface surface;
    surface.body = body;
    surface.T_body_surface = box.T_body_box * Pose3(R, box.half.cwiseProduct(R.col(2)));
    surface.half = {std::abs(box.half.dot(R.col(0))), std::abs(R.col(1).dot(box.half))};
    surface.colour = box.colour;
    surface.texture = box.texture;
    surfaces.push_back(surface);
  }
}

void addSheet(const TagSheet& tag, std::size_t body, std::vector<Surface>& surfaces) {
  constexpr double kSheetPerTag = 10.0 / 8.0;
  Surface surface;
  surface.body = body;
  surface.T_body_surface = tag.T_body_tag;
  surface.half = Vector2::Constant(0.5 * kSheetPerTag * tag.size_m);
  surface.colour = Colour::Constant(0.9f);
  surface.tag = &tag;
  surfaces.push_back(surface);
}

void attachQuads(RTCDevice device, RTCScene scene, std::span<const Surface> surfaces) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_QUAD);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                               RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                               4 * surfaces.size()));
  auto* indices = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, 4 * sizeof(unsigned), surfaces.size()));
  constexpr std::array<std::array<double, 2>, 4> kCorners{{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}};
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    const Surface& s = surfaces[i];
    for (std::size_t k = 0; k < 4; ++k) {
      const Vector3 corner =
          s.T_body_surface * Vector3(kCorners[k][0] * s.half.x(), kCorners[k][1] * s.half.y(), 0);
      for (int axis = 0; axis < 3; ++axis) *vertices++ = static_cast<float>(corner[axis]);
      *indices++ = static_cast<unsigned>(4 * i + k);
    }
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
}

RTCQuaternionDecomposition decomposition(const Pose3& T) {
  RTCQuaternionDecomposition d;
  rtcInitQuaternionDecomposition(&d);
  const Eigen::Quaternionf q = T.quaternion().cast<float>();
  rtcQuaternionDecompositionSetQuaternion(&d, q.w(), q.x(), q.y(), q.z());
  rtcQuaternionDecompositionSetTranslation(
      &d, static_cast<float>(T.t.x()), static_cast<float>(T.t.y()), static_cast<float>(T.t.z()));
  return d;
}

}  // namespace

struct RayCaster::Impl {
  Device device{rtcNewDevice("threads=1")};
  std::vector<Surface> surfaces;
  std::vector<std::uint32_t> first_surface;    ///< of each body
  std::vector<std::unique_ptr<Scene>> scenes;  ///< of each body
};

RayCaster::RayCaster(const std::vector<Body>& bodies) : impl_(std::make_unique<Impl>()) {
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    impl_->first_surface.push_back(static_cast<std::uint32_t>(impl_->surfaces.size()));
    for (const Box& box : bodies[i].boxes) addFaces(box, i, impl_->surfaces);
    for (const TagSheet& tag : bodies[i].tags) addSheet(tag, i, impl_->surfaces);
    const auto own = std::span(impl_->surfaces).subspan(impl_->first_surface.back());
    auto scene = std::make_unique<Scene>(rtcNewScene(impl_->device.get()));
    rtcSetSceneFlags(scene->get(), RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene->get(), RTC_BUILD_QUALITY_HIGH);
    attachQuads(impl_->device.get(), scene->get(), own);
    rtcCommitScene(scene->get());
    impl_->scenes.push_back(std::move(scene));
  }
}

RayCaster::~RayCaster() = default;

const std::vector<Surface>& RayCaster::surfaces() const { return impl_->surfaces; }

struct RayCaster::Snapshot::Impl {
  explicit Impl(const RayCaster::Impl& caster)
      : shared(caster), scene(rtcNewScene(caster.device.get())) {}
  const RayCaster::Impl& shared;
  Scene scene;
  std::vector<RTCGeometry> instances;  ///< owned by the scene
};

RayCaster::Snapshot::Snapshot(const RayCaster& caster)
    : impl_(std::make_unique<Impl>(*caster.impl_)) {
  rtcSetSceneFlags(impl_->scene.get(), RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_DYNAMIC);
  for (std::size_t i = 0; i < impl_->shared.scenes.size(); ++i) {
    RTCGeometry instance = rtcNewGeometry(impl_->shared.device.get(), RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(instance, impl_->shared.scenes[i]->get());
    const auto still = decomposition(Pose3());
    rtcSetGeometryTransformQuaternion(instance, 0, &still);
    rtcCommitGeometry(instance);
    rtcAttachGeometryByID(impl_->scene.get(), instance, static_cast<unsigned>(i));
    rtcReleaseGeometry(instance);
    impl_->instances.push_back(instance);
  }
}

RayCaster::Snapshot::~Snapshot() = default;

void RayCaster::Snapshot::place(std::span<const std::vector<Pose3>> instants) {
  for (std::size_t i = 1; i < impl_->instances.size(); ++i) {
    RTCGeometry instance = impl_->instances[i];
    rtcSetGeometryTimeStepCount(instance, static_cast<unsigned>(instants.size()));
    for (std::size_t k = 0; k < instants.size(); ++k) {
      const auto transform = decomposition(instants[k][i - 1]);
      rtcSetGeometryTransformQuaternion(instance, static_cast<unsigned>(k), &transform);
    }
    rtcCommitGeometry(instance);
  }
  rtcCommitScene(impl_->scene.get());
}

void RayCaster::Snapshot::cast(std::span<const Ray> rays, std::span<Hit> hits) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  for (std::size_t begin = 0; begin < rays.size(); begin += kPacket) {
    RTCRayHit8 packet;
    alignas(32) std::array<int, kPacket> valid;
    for (std::size_t k = 0; k < kPacket; ++k) {
      const Ray& ray = rays[std::min(begin + k, rays.size() - 1)];
      valid[k] = begin + k < rays.size() ? -1 : 0;
      packet.ray.org_x[k] = ray.origin.x();
      packet.ray.org_y[k] = ray.origin.y();
      packet.ray.org_z[k] = ray.origin.z();
      packet.ray.dir_x[k] = ray.direction.x();
      packet.ray.dir_y[k] = ray.direction.y();
      packet.ray.dir_z[k] = ray.direction.z();
      packet.ray.tnear[k] = 0.0f;
      packet.ray.tfar[k] = std::numeric_limits<float>::infinity();
      packet.ray.time[k] = ray.time;
      packet.ray.mask[k] = ~0u;
      packet.ray.id[k] = 0;
      packet.ray.flags[k] = 0;
      packet.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
      packet.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect8(valid.data(), impl_->scene.get(), &context, &packet);
    for (std::size_t k = 0; k < kPacket && begin + k < rays.size(); ++k) {
      Hit& hit = hits[begin + k];
      if (packet.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID) {
        hit = {std::numeric_limits<float>::infinity(), 0};
      } else {
        const unsigned body = packet.hit.instID[0][k];
        hit = {packet.ray.tfar[k], impl_->shared.first_surface[body] + packet.hit.primID[k]};
      }
    }
  }
}

}  // namespace dynemo::simulation
