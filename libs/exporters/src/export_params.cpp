#include "dynemo/exporters/export_params.h"

#include <yaml-cpp/yaml.h>

#include "dynemo/core/config.h"
#include "dynemo/core/error.h"

namespace dynemo {

void fields(FieldVisitor& v, MapCloudParams& p) {
  v.optionalNumber("at_s", p.at_s,
                   "Entities stand where they were so many seconds after the first frame; null for "
                   "the end");
  v.choice("entities", p.entities, {"all", "unmoved", "none"},
           "Entities with their points: all, objects that were never seen moving, none");
  v.number("agents_within_s", p.agents_within_s,
           "Agents have points when seen at most so long before or after", Range::nonNegative());
  v.number("voxel_m", p.voxel_m, "One point per voxel of this size; 0 keeps all points",
           Range::between(0.0, 10.0));
}

void fields(FieldVisitor& v, PictureParams& p) {
  v.number("cutaway_height_m", p.cutaway_height_m,
           "Points higher than this over the robot are not drawn, to look into rooms from above",
           Range::any());
  v.number("voxel_m", p.voxel_m, "One point of the structure per voxel of this size",
           Range::between(0.001, 10.0));
  v.integer("max_points", p.max_points, "Voxels grow while there are more points than this",
            Range::between(100, 10'000'000));
}

void fields(FieldVisitor& v, PngParams& p) {
  v.integer("width_px", p.width_px, "Width of one view", Range::between(64, 8192));
  v.integer("height_px", p.height_px, "Height of one view", Range::between(64, 8192));
  v.choice("view", p.view, {"perspective", "above", "both"}, "Where the camera stands");
}

void fields(FieldVisitor& v, ExportParams& p) {
  v.section("cloud", p.cloud, "Map cloud: ply, pcd");
  v.section("picture", p.picture, "What is drawn: 3dscene, png, gltf, html");
  v.section("png", p.png, "Rendered picture");
  v.section("structure", p.structure,
            "What is taken for structure, and not for something that moves: ply, pcd, map, and "
            "what is drawn");
  v.section("query", p.query, "What is believed of entities while nobody looks at them");
}

ExportParams exportParamsOf(const std::string& config_yaml) {
  constexpr const char* kOrigin = "exports of the run's configuration";
  ExportParams params;
  YAML::Node section;
  try {
    section = YAML::Load(config_yaml)["exports"];
  } catch (const YAML::Exception& e) {
    throw ConfigError(std::string(kOrigin) + ": " + e.what());
  }
  if (!section || section.IsNull()) return params;
  ConfigLoader loader;
  loader.addText(YAML::Dump(section), kOrigin);
  load(loader, params);
  return params;
}

}  // namespace dynemo
