// A picture of the scene by MRPT's off-screen renderer: in perspective and from above, with the
// names of the entities and a legend.
#include <mrpt/opengl/CFBORender.h>

#include <cmath>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "dynemo/core/error.h"
#include "dynemo/core/mrpt_conversions.h"
#include "dynemo/core/output_file.h"
#include "dynemo/query/entity_extent.h"
#include "edge_lines.h"
#include "entity_color.h"
#include "factories.h"
#include "picture_overlay.h"
#include "scene.h"
#include "scene_view.h"

namespace dynemo {
namespace {

/// Rendered this much larger and averaged, so that edges are smooth.
constexpr int kSupersampling = 2;

mrpt::opengl::CCamera mrptCamera(const PictureCamera& camera) {
  mrpt::img::TCamera pinhole;
  pinhole.ncols = static_cast<std::uint32_t>(kSupersampling * camera.width_px);
  pinhole.nrows = static_cast<std::uint32_t>(kSupersampling * camera.height_px);
  pinhole.setIntrinsicParamsFromValues(kSupersampling * camera.focal_px,
                                       kSupersampling * camera.focal_px, 0.5 * pinhole.ncols,
                                       0.5 * pinhole.nrows);
  mrpt::opengl::CCamera placed;
  placed.set6DOFMode(true);
  placed.setPose(toMrpt(camera.T_map_camera));
  placed.setProjectiveFromPinhole(pinhole);
  return placed;
}

/// One renderer for all views: a scene's buffers belong to the context of its first rendering.
class Renderer {
 public:
  Renderer(mrpt::opengl::COpenGLScene scene, const PngParams& params) : scene_(std::move(scene)) {
    guarded([&] {
      renderer_ = std::make_unique<mrpt::opengl::CFBORender>(mrpt::opengl::CFBORender::Parameters(
          static_cast<unsigned>(kSupersampling * params.width_px),
          static_cast<unsigned>(kSupersampling * params.height_px)));
    });
  }

  cv::Mat render(const PictureCamera& camera) {
    scene_.getViewport()->setViewportClipDistances(static_cast<float>(0.02 * camera.distance_m),
                                                   static_cast<float>(10.0 * camera.distance_m));
    mrpt::img::CImage image;
    guarded([&] {
      renderer_->setCamera(scene_, mrptCamera(camera));
      renderer_->render_RGB(scene_, image);
    });
    cv::Mat picture;
    cv::resize(image.asCvMat<cv::Mat>(mrpt::img::SHALLOW_COPY), picture,
               {camera.width_px, camera.height_px}, 0, 0, cv::INTER_AREA);
    return picture;
  }

 private:
  template <class Action>
  static void guarded(const Action& action) {
    try {
      action();
    } catch (const std::exception& e) {
      throw DataError("png: cannot be rendered (it takes EGL, Debian's libegl-mesa0): " +
                      mrptReason(e));
    }
  }

  // The context outlives the scene's buffers.
  std::unique_ptr<mrpt::opengl::CFBORender> renderer_;
  mrpt::opengl::COpenGLScene scene_;
};

std::vector<PictureLabel> labelsOf(const CSceneGraph& graph) {
  std::vector<PictureLabel> labels;
  for (const auto& [id, track] : graph.tracks()) {
    const CNodeEntity& last = *track.back();
    const Extent extent = extentOf(fragmentPoints(graph, track)).value_or(Extent());
    const Vector3 top(0.0, 0.0, extent.max.z());
    labels.push_back({entityTitle(last), last.T_map_entity() * top, entityRgb(id)});
  }
  return labels;
}

std::vector<LegendEntry> legendOf(const RunResult& run) {
  std::vector<LegendEntry> entries = {{"trajectory", kTrajectoryRgb},
                                      {"odometry alone", kOdometryRgb}};
  for (const EdgeKindLines& kind : edgeLines(run.graph)) {
    std::string name = kind.kind;
    std::replace(name.begin(), name.end(), '_', ' ');
    entries.push_back({name + ": " + std::to_string(kind.edges.size()), kind.color_rgb});
  }
  return entries;
}

std::string titleOf(const RunResult& run) {
  return std::to_string(run.graph.keyframes().size()) + " keyframes, " +
         std::to_string(run.graph.tracks().size()) + " entities, " +
         std::to_string(run.graph.edgeCount()) + " edges";
}

class PngExporter : public Exporter {
 public:
  explicit PngExporter(const ExportParams& params) : params_(params) {}
  std::string fileName() const override { return "scene.png"; }

  void write(const RunResult& run, const std::filesystem::path& file) const override {
    SceneParams style{params_};
    style.labels = false;
    style.cloud_point_px *= kSupersampling;
    style.fragment_point_px *= kSupersampling;
    style.edge_line_px *= kSupersampling;
    Renderer renderer(makeScene(run, style), params_.png);
    std::vector<cv::Mat> views;
    if (params_.png.view != PngView::kAbove) views.push_back(perspective(run, renderer));
    if (params_.png.view != PngView::kPerspective) views.push_back(above(run, renderer));
    cv::Mat picture;
    cv::hconcat(views, picture);
    std::vector<unsigned char> bytes;
    cv::imencode(".png", picture, bytes);
    writeFileAtomically(file, std::string(bytes.begin(), bytes.end()));
  }

 private:
  static constexpr double kDegree = std::numbers::pi / 180.0;

  cv::Mat perspective(const RunResult& run, Renderer& renderer) const {
    constexpr double kFieldOfView = 35.0 * kDegree, kElevation = 50.0 * kDegree;
    const SceneView view = viewOf(run.graph);
    const double smaller =
        std::min(1.0, static_cast<double>(params_.png.width_px) / params_.png.height_px);
    const double distance_m = view.radius_m / std::tan(0.5 * kFieldOfView) / smaller;
    const PictureCamera camera =
        lookAt(view.center, distance_m, view.yaw_rad - 65.0 * kDegree, kElevation, kFieldOfView,
               params_.png.width_px, params_.png.height_px);
    cv::Mat picture = renderer.render(camera);
    drawLabels(picture, camera, labelsOf(run.graph));
    drawLegend(picture, titleOf(run), legendOf(run));
    return picture;
  }

  /// From so far away that distances are the same all over the picture, the long side across.
  cv::Mat above(const RunResult& run, Renderer& renderer) const {
    constexpr double kFieldOfView = 5.0 * kDegree, kMargin = 1.1;
    const SceneView view = viewOf(run.graph);
    const double height_m =
        2.0 * kMargin *
        std::max(view.half_m.y(), view.half_m.x() * params_.png.height_px / params_.png.width_px);
    const PictureCamera camera = lookAt(view.center, 0.5 * height_m / std::tan(0.5 * kFieldOfView),
                                        view.yaw_rad - 90.0 * kDegree, 90.0 * kDegree, kFieldOfView,
                                        params_.png.width_px, params_.png.height_px);
    cv::Mat picture = renderer.render(camera);
    drawLabels(picture, camera, labelsOf(run.graph));
    drawScale(picture, camera);
    return picture;
  }

  ExportParams params_;
};

}  // namespace

std::unique_ptr<Exporter> makePngExporter(const ExportParams& params) {
  return std::make_unique<PngExporter>(params);
}

}  // namespace dynemo
