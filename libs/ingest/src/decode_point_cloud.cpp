// CObservationPointCloud with any class of point map, embedded or in an external file.
#include <mrpt/maps/CPointsMap.h>
#include <mrpt/obs/CObservationPointCloud.h>

#include "dynemo/ingest/decoders.h"
#include "memory_limit.h"
#include "scan_builder.h"

namespace dynemo {
namespace {

using mrpt::obs::CObservationPointCloud;

/// The members that MRPT has no accessor for.
struct Access : CObservationPointCloud {
  static ExternalStorageFormat format(const CObservationPointCloud& o) {
    return o.*(&Access::m_externally_stored);
  }
};

/// Reads the external file under its absolute path.
std::optional<DecodeFailure> loadExternal(CObservationPointCloud& o, const DecodeContext& context) {
  const std::string stored_name = o.getExternalStorageFile();
  const auto path = context.files.find(stored_name);
  if (!path) return DecodeFailure("external cloud file not found", stored_name);
  const auto format = Access::format(o);
  o.overrideExternalStorageFormatFlag(CObservationPointCloud::ExternalStorageFormat::None);
  o.setAsExternalStorage(path->string(), format);
  try {
    const MemoryLimit limit(static_cast<std::size_t>(context.params.max_object_mb * 1e6));
    o.load();
  } catch (const std::exception&) {
    return DecodeFailure("external cloud file cannot be read", stored_name);
  }
  return std::nullopt;
}

}  // namespace

Expected<Scan, DecodeFailure> decodePointCloud(mrpt::obs::CObservation& observation,
                                               const DecodeContext& context) {
  auto& o = dynamic_cast<CObservationPointCloud&>(observation);
  if (o.isExternallyStored() && !o.pointcloud) {
    const auto failure = loadExternal(o, context);
    if (failure) return make_unexpected(*failure);
  }
  if (!o.pointcloud) return make_unexpected("the observation has no cloud");
  const auto& x = o.pointcloud->getPointsBufferRef_x();
  const auto& y = o.pointcloud->getPointsBufferRef_y();
  const auto& z = o.pointcloud->getPointsBufferRef_z();
  ScanBuilder scan(context, x.size());
  for (std::size_t i = 0; i < x.size(); ++i) scan.add({x[i], y[i], z[i]});
  return scan.finish(o);
}

}  // namespace dynemo
