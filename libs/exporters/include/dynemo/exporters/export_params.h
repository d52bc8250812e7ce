#pragma once

#include <optional>
#include <string>

#include "dynemo/core/fields.h"
#include "dynemo/query/query_params.h"
#include "dynemo/query/structure_params.h"

namespace dynemo {

/// Whose points the map cloud holds besides those of the structure.
enum class EntityPoints {
  kAll,      ///< of every entity that is there at the time
  kUnmoved,  ///< of objects that were never seen moving
  kNone
};

/// The map cloud of `ply` and `pcd`.
struct MapCloudParams {
  /// Time at which entities stand where they are drawn, in seconds after the first frame; empty for
  /// the end.
  std::optional<double> at_s;
  EntityPoints entities = EntityPoints::kAll;
  /// Agents are drawn when they were seen at most this long before or after.
  double agents_within_s = 1.0;
  /// One point per voxel of this size; 0 keeps all points.
  double voxel_m = 0.05;
};
void fields(FieldVisitor& v, MapCloudParams& p);

/// What `3dscene`, `png`, `gltf` and `html` draw.
struct PictureParams {
  /// Points higher than this over their keyframe's base are cut away, so that one can look into
  /// rooms from above.
  double cutaway_height_m = 1.6;
  /// Points of the structure are thinned to one per voxel; to larger voxels while they exceed the
  /// number.
  double voxel_m = 0.04;
  int max_points = 300'000;
};
void fields(FieldVisitor& v, PictureParams& p);

enum class PngView { kPerspective, kAbove, kBoth };

struct PngParams {
  /// Size of one view; both stand side by side.
  int width_px = 1280, height_px = 960;
  PngView view = PngView::kBoth;
};
void fields(FieldVisitor& v, PngParams& p);

/// Options of all exporters: the section `exports` of the configuration.
struct ExportParams {
  MapCloudParams cloud;
  PictureParams picture;
  PngParams png;
  StructureParams structure;
  QueryParams query;
};
void fields(FieldVisitor& v, ExportParams& p);

/// The section `exports` of a configuration (as a session stores it), the defaults where it says
/// nothing. Throws ConfigError as any configuration.
ExportParams exportParamsOf(const std::string& config_yaml);

}  // namespace dynemo
