// The exporters of this library; each is implemented in the file of its name.
#pragma once

#include <memory>

#include "dynemo/exporters/exporter.h"

namespace dynemo {

/// trajectory.tum: T_map_base of every frame, optimised.
std::unique_ptr<Exporter> makeTrajectoryExporter(const ExportParams& params);
/// keyframes.tum: T_map_base of every keyframe, optimised.
std::unique_ptr<Exporter> makeKeyframesExporter(const ExportParams& params);
/// odometry.tum: T_odom_base of every frame, as measured.
std::unique_ptr<Exporter> makeOdometryExporter(const ExportParams& params);
/// entities.csv: one row per entity node.
std::unique_ptr<Exporter> makeEntitiesExporter(const ExportParams& params);
/// planes.csv: one row per plane node.
std::unique_ptr<Exporter> makePlanesExporter(const ExportParams& params);
/// graph.g2o: the poses of keyframes and entities with the relative-pose edges between them.
std::unique_ptr<Exporter> makeG2oExporter(const ExportParams& params);
/// graph.graph: the keyframes' pose graph for MRPT's graph-slam.
std::unique_ptr<Exporter> makeMrptGraphExporter(const ExportParams& params);
/// poses/: a TUM trajectory of the robot and one per entity.
std::unique_ptr<Exporter> makeTumExporter(const ExportParams& params);
/// tables/: nodes, edges, moves as CSV tables.
std::unique_ptr<Exporter> makeTablesExporter(const ExportParams& params);
/// map.ply, map.pcd: the map cloud in colour.
std::unique_ptr<Exporter> makePlyExporter(const ExportParams& params);
std::unique_ptr<Exporter> makePcdExporter(const ExportParams& params);
/// scene_graph.json: for spark_dsg.
std::unique_ptr<Exporter> makeSparkDsgExporter(const ExportParams& params);
/// scene.glb, or .gltf: the scene graph in layers, with an animation.
std::unique_ptr<Exporter> makeGltfExporter(const ExportParams& params);
/// scene.png: rendered without a display.
std::unique_ptr<Exporter> makePngExporter(const ExportParams& params);
/// scene.html: one self-contained web page with everything and a time slider.
std::unique_ptr<Exporter> makeHtmlExporter(const ExportParams& params);
/// scene.3Dscene: everything in one picture, for SceneViewer3D.
std::unique_ptr<Exporter> makeScene3dExporter(const ExportParams& params);
/// map.png: structure and path from above, before and after the loop closures.
std::unique_ptr<Exporter> makeMapFigureExporter(const ExportParams& params);

}  // namespace dynemo
