// CObservation3DRangeScan: points from the depth image with the camera's own intrinsics, else the
// stored points.
#include <mrpt/obs/CObservation3DRangeScan.h>

#include "dynemo/ingest/decoders.h"
#include "memory_limit.h"
#include "scan_builder.h"

namespace dynemo {
namespace {

using mrpt::obs::CObservation3DRangeScan;

/// The members that MRPT has no accessor for.
struct Access : CObservation3DRangeScan {
  static std::string& rangeFile(CObservation3DRangeScan& o) {
    return o.*(&Access::m_rangeImage_external_file);
  }
  static std::string& pointsFile(CObservation3DRangeScan& o) {
    return o.*(&Access::m_points3D_external_file);
  }
};

std::optional<DecodeFailure> makeAbsolute(std::string& stored_name, const DecodeContext& context) {
  const auto path = context.files.find(stored_name);
  if (!path) return DecodeFailure("external depth file not found", stored_name);
  stored_name = path->string();
  return std::nullopt;
}

/// Reads external files under their absolute paths.
std::optional<DecodeFailure> loadExternal(CObservation3DRangeScan& o,
                                          const DecodeContext& context) {
  std::optional<DecodeFailure> failure;
  if (o.rangeImage_isExternallyStored()) failure = makeAbsolute(Access::rangeFile(o), context);
  if (!failure && o.points3D_isExternallyStored())
    failure = makeAbsolute(Access::pointsFile(o), context);
  if (failure) return failure;
  const MemoryLimit limit(static_cast<std::size_t>(context.params.max_object_mb * 1e6));
  o.load();
  return std::nullopt;
}

Expected<Scan, DecodeFailure> fromDepth(const CObservation3DRangeScan& o,
                                        const DecodeContext& context) {
  const auto rows = static_cast<std::size_t>(o.rangeImage.rows());
  const auto columns = static_cast<std::size_t>(o.rangeImage.cols());
  // Ray of each pixel, of unit depth or unit length as range_is_depth says.
  const auto& rays = o.get_unproj_lut();
  if (rays.Kxs.size() != rows * columns || rays.Kys.size() != rows * columns ||
      rays.Kzs.size() != rows * columns)
    return make_unexpected("the depth image does not have the size of its calibration");
  ScanBuilder scan(context, rows * columns);
  scan.organise(rows, columns);
  for (std::size_t r = 0, i = 0; r < rows; ++r) {
    for (std::size_t c = 0; c < columns; ++c, ++i) {
      const std::uint16_t units = o.rangeImage(static_cast<int>(r), static_cast<int>(c));
      if (units == 0) continue;
      const float range_m = static_cast<float>(units) * o.rangeUnits;
      scan.add({range_m * rays.Kxs[i], range_m * rays.Kys[i], range_m * rays.Kzs[i]}, std::nullopt,
               r, c);
    }
  }
  return scan.finish(o);
}

Expected<Scan, DecodeFailure> fromPoints(const CObservation3DRangeScan& o,
                                         const DecodeContext& context) {
  const std::size_t n = std::min({o.points3D_x.size(), o.points3D_y.size(), o.points3D_z.size()});
  ScanBuilder scan(context, n);
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector3f p(o.points3D_x[i], o.points3D_y[i], o.points3D_z[i]);
    // MRPT marks pixels without a return by the origin.
    if (!p.isZero(0.0F)) scan.add(p);
  }
  return scan.finish(o);
}

}  // namespace

Expected<Scan, DecodeFailure> decode3DRangeScan(mrpt::obs::CObservation& observation,
                                                const DecodeContext& context) {
  auto& o = dynamic_cast<CObservation3DRangeScan&>(observation);
  try {
    const auto failure = loadExternal(o, context);
    if (failure) return make_unexpected(*failure);
    if (o.hasRangeImage && !o.rangeImage.empty()) return fromDepth(o, context);
    if (o.hasPoints3D) return fromPoints(o, context);
  } catch (const std::exception&) {
    // MRPT asserts on external files it cannot read and on inconsistent calibration.
    return make_unexpected("the depth image cannot be converted");
  }
  return make_unexpected("the observation has neither depth nor points");
}

}  // namespace dynemo
