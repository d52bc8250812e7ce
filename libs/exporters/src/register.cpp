#include "factories.h"

namespace dynemo {

const ExporterRegistry& exporters() {
  static const ExporterRegistry registry = [] {
    ExporterRegistry r("output");
    r.add("trajectory", makeTrajectoryExporter);
    r.add("keyframes", makeKeyframesExporter);
    r.add("odometry", makeOdometryExporter);
    r.add("entities", makeEntitiesExporter);
    r.add("planes", makePlanesExporter);
    r.add("tum", makeTumExporter);
    r.add("csv", makeTablesExporter);
    r.add("ply", makePlyExporter);
    r.add("pcd", makePcdExporter);
    r.add("gltf", makeGltfExporter);
    r.add("png", makePngExporter);
    r.add("html", makeHtmlExporter);
    r.add("spark-dsg", makeSparkDsgExporter);
    r.add("g2o", makeG2oExporter);
    r.add("graph", makeMrptGraphExporter);
    r.add("3dscene", makeScene3dExporter);
    r.add("map", makeMapFigureExporter);
    return r;
  }();
  return registry;
}

}  // namespace dynemo
