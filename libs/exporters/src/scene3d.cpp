// MRPT's 3-D scene file, as SceneViewer3D opens it.
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/opengl/COpenGLScene.h>
#include <mrpt/serialization/CArchive.h>
#include <zlib.h>

#include <algorithm>
#include <limits>
#include <new>

#include "dynemo/core/error.h"
#include "dynemo/core/output_file.h"
#include "factories.h"
#include "scene_style.h"

namespace dynemo {
namespace {

struct View {
  Vector3 center = Vector3::Zero();
  double radius_m = 1.0;
};

/// Some points of all keyframes, and the keyframes themselves.
std::vector<Vector3> samplePoints(const CSceneGraph& graph) {
  constexpr std::size_t kStride = 53;
  std::vector<Vector3> points;
  for (const auto& keyframe : graph.keyframes()) {
    points.push_back(keyframe->T_map_base().t);
    if (!keyframe->scan) continue;
    const Pose3 T_map_lidar = keyframe->T_map_base() * keyframe->scan->T_base_lidar;
    const auto& cloud = keyframe->scan->cloud.points;
    for (std::size_t i = 0; i < cloud.size(); i += kStride) {
      points.push_back(T_map_lidar * cloud[i].cast<double>());
    }
  }
  std::erase_if(points, [](const Vector3& p) { return !p.allFinite(); });
  return points;
}

/// The ball around most of the points: far returns through a window do not make the picture small.
View viewOf(std::vector<Vector3> points) {
  if (points.empty()) return {};
  const std::size_t tail = points.size() / 50;
  Vector3 min, max;
  for (int axis = 0; axis < 3; ++axis) {
    std::sort(points.begin(), points.end(),
              [axis](const Vector3& a, const Vector3& b) { return a[axis] < b[axis]; });
    min[axis] = points[tail][axis];
    max[axis] = points[points.size() - 1 - tail][axis];
  }
  return {0.5 * (min + max), std::max(1.0, 0.5 * (max - min).norm())};
}

void setCamera(mrpt::opengl::COpenGLViewport& viewport, const View& view,
               const SceneParams& params) {
  auto& camera = viewport.getCamera();
  camera.setPointingAt(toPoint(view.center));
  camera.setZoomDistance(static_cast<float>(3.0 * view.radius_m));
  camera.setAzimuthDegrees(params.azimuth_deg);
  camera.setElevationDegrees(params.elevation_deg);
}

mrpt::opengl::COpenGLScene makeScene(const RunResult& run, const SceneParams& params) {
  mrpt::opengl::COpenGLScene scene;
  scene.getViewport()->setCustomBackgroundColor({1.0f, 1.0f, 1.0f});
  // Colours stay what they mean on the sides away from the light, too.
  scene.getViewport()->lightParameters().ambient = {0.5f, 0.5f, 0.5f};
  scene.getViewport()->lightParameters().diffuse = {0.5f, 0.5f, 0.5f};
  setCamera(*scene.getViewport(), viewOf(samplePoints(run.graph)), params);
  // What is translucent comes last.
  for (const auto part :
       {sceneFloors, sceneClouds, sceneTrajectory, sceneEdges, sceneEntities, scenePlanes}) {
    scene.insert(part(run, params));
  }
  return scene;
}

/// As a gzip file, packed in memory: MRPT's own packing goes through a temporary file, and a full
/// disk there goes unnoticed. The header holds no time, so equal scenes give equal bytes.
std::string compressed(const mrpt::opengl::COpenGLScene& scene) {
  mrpt::io::CMemoryStream memory;
  auto archive = mrpt::serialization::archiveFrom(memory);
  archive << scene;

  constexpr int kLevel = 6, kGzipWindow = 15 + 16, kMemoryLevel = 8;
  if (memory.getTotalBytesCount() > std::numeric_limits<uInt>::max()) {
    throw DataError("scene.3Dscene: too large to be compressed");
  }
  z_stream stream{};
  if (deflateInit2(&stream, kLevel, Z_DEFLATED, kGzipWindow, kMemoryLevel, Z_DEFAULT_STRATEGY) !=
      Z_OK) {
    throw std::bad_alloc();
  }
  std::string packed(deflateBound(&stream, memory.getTotalBytesCount()), '\0');
  stream.next_in = static_cast<Bytef*>(memory.getRawBufferData());
  stream.avail_in = static_cast<uInt>(memory.getTotalBytesCount());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  const int result = deflate(&stream, Z_FINISH);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  if (result != Z_STREAM_END) throw DataError("scene.3Dscene: too large to be compressed");
  return packed;
}

class Scene3dExporter : public Exporter {
 public:
  std::string fileName() const override { return "scene.3Dscene"; }
  void write(const RunResult& run, const std::filesystem::path& file) const override {
    writeFileAtomically(file, compressed(makeScene(run, SceneParams())));
  }
};

}  // namespace

std::unique_ptr<Exporter> makeScene3dExporter() { return std::make_unique<Scene3dExporter>(); }

}  // namespace dynemo
