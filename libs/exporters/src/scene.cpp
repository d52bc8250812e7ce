#include "scene.h"

#include "scene_view.h"

namespace dynemo {
namespace {

void setCamera(mrpt::opengl::COpenGLViewport& viewport, const SceneView& view,
               const SceneParams& params) {
  auto& camera = viewport.getCamera();
  camera.setPointingAt(toPoint(view.center));
  camera.setZoomDistance(static_cast<float>(3.0 * view.radius_m));
  camera.setAzimuthDegrees(params.azimuth_deg);
  camera.setElevationDegrees(params.elevation_deg);
}

}  // namespace

mrpt::opengl::COpenGLScene makeScene(const RunResult& run, const SceneParams& params) {
  mrpt::opengl::COpenGLScene scene;
  scene.getViewport()->setCustomBackgroundColor({1.0f, 1.0f, 1.0f});
  // Colours stay what they mean on the sides away from the light, too.
  scene.getViewport()->lightParameters().ambient = {0.5f, 0.5f, 0.5f};
  scene.getViewport()->lightParameters().diffuse = {0.5f, 0.5f, 0.5f};
  setCamera(*scene.getViewport(), viewOf(run.graph), params);
  // What is translucent comes last.
  for (const auto part :
       {sceneFloors, sceneClouds, sceneTrajectory, sceneEdges, sceneEntities, scenePlanes}) {
    scene.insert(part(run, params));
  }
  return scene;
}

}  // namespace dynemo
