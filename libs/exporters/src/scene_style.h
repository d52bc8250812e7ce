// Colours and sizes of the 3-D scene, and the parts it is built from.
#pragma once

#include <mrpt/img/TColor.h>
#include <mrpt/math/TPoint3D.h>
#include <mrpt/opengl/CSetOfObjects.h>
#include <mrpt/opengl/CSetOfTriangles.h>

#include <cstdint>

#include "dynemo/exporters/export_params.h"
#include "dynemo/exporters/run_result.h"

namespace dynemo {

/// What the exporter draws, in metres unless the name says otherwise.
struct SceneParams {
  ExportParams exports;
  float cloud_point_px = 1.5f;
  float fragment_point_px = 3.0f;
  double trajectory_radius_m = 0.03;
  double track_radius_m = 0.025;
  /// Tubes bend at most this often: shorter steps are joined.
  double shortest_step_m = 0.1;
  float edge_line_px = 1.0f;
  float text_height_m = 0.22f;
  /// Where the default camera stands, as SceneViewer3D starts.
  float azimuth_deg = 45.0f;
  float elevation_deg = 50.0f;
  std::uint8_t plane_alpha = 70;
  bool labels = true;
};

constexpr std::uint32_t kTrajectoryRgb = 0x1a4fd6, kOdometryRgb = 0x606060;

inline mrpt::math::TPoint3D toPoint(const Vector3& p) { return {p.x(), p.y(), p.z()}; }

/// 0xRRGGBB.
mrpt::img::TColor colorFromRgb(std::uint32_t rgb, std::uint8_t alpha = 255);

/// Well separated colours, the same for one entity in every run.
mrpt::img::TColor entityColor(EntityId id, std::uint8_t alpha = 255);

/// A solid line of the given radius through the points; OpenGL draws plain lines one pixel wide on
/// many systems.
mrpt::opengl::CSetOfTriangles::Ptr tube(const std::vector<Vector3>& points, double radius_m,
                                        double shortest_step_m, const mrpt::img::TColor& color);

/// Text over a point, turned to the default camera and leaning back so that it can be read from
/// above, too. (MRPT's texts that follow the viewer vanish behind clouds.)
mrpt::opengl::CSetOfObjects::Ptr label(const std::string& text, const Vector3& p_map,
                                       const mrpt::img::TColor& color, const SceneParams& params);

/// The keyframes' clouds and, in colour, the fragments of the entities.
mrpt::opengl::CSetOfObjects::Ptr sceneClouds(const RunResult& run, const SceneParams& params);
/// Optimised trajectory, odometry for comparison, keyframe axes.
mrpt::opengl::CSetOfObjects::Ptr sceneTrajectory(const RunResult& run, const SceneParams& params);
/// Entities as labelled boxes at their latest pose, tracks of agents, displaced objects before and
/// after.
mrpt::opengl::CSetOfObjects::Ptr sceneEntities(const RunResult& run, const SceneParams& params);
/// The edges of the graph in the colours of their kinds, and a grid per floor.
mrpt::opengl::CSetOfObjects::Ptr sceneEdges(const RunResult& run, const SceneParams& params);
/// Walls as far as they were seen, translucent.
mrpt::opengl::CSetOfObjects::Ptr scenePlanes(const RunResult& run, const SceneParams& params);
mrpt::opengl::CSetOfObjects::Ptr sceneFloors(const RunResult& run, const SceneParams& params);

}  // namespace dynemo
