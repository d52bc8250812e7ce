// The exporters of this library; each is implemented in the file of its name.
#pragma once

#include <memory>

#include "dynemo/exporters/exporter.h"

namespace dynemo {

/// trajectory.tum: T_map_base of every frame, optimised.
std::unique_ptr<Exporter> makeTrajectoryExporter();
/// keyframes.tum: T_map_base of every keyframe, optimised.
std::unique_ptr<Exporter> makeKeyframesExporter();
/// odometry.tum: T_odom_base of every frame, as measured.
std::unique_ptr<Exporter> makeOdometryExporter();
/// entities.csv: one row per entity node.
std::unique_ptr<Exporter> makeEntitiesExporter();
/// planes.csv: one row per plane node.
std::unique_ptr<Exporter> makePlanesExporter();
/// graph.g2o: the poses of keyframes and entities with the relative-pose edges between them.
std::unique_ptr<Exporter> makeG2oExporter();
/// graph.graph: the keyframes' pose graph for MRPT's graph-slam.
std::unique_ptr<Exporter> makeMrptGraphExporter();
/// scene.3Dscene: everything in one picture, for SceneViewer3D.
std::unique_ptr<Exporter> makeScene3dExporter();
/// map.png: structure and path from above, before and after the loop closures.
std::unique_ptr<Exporter> makeMapFigureExporter();

}  // namespace dynemo
