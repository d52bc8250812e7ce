// set-extrinsics, set-calibration and relabel.
#include <mrpt/containers/yaml.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationImage.h>

#include <cmath>

#include "dynemo/core/error.h"
#include "dynemo/core/mrpt_conversions.h"
#include "rewriting.h"

namespace dynemo {

namespace fs = std::filesystem;

RewriteReport setExtrinsics(const fs::path& input, const fs::path& output,
                            const std::map<std::string, Pose3>& T_base_sensor,
                            const RewriteOptions& options) {
  std::set<std::string> wanted;
  for (const auto& [label, pose] : T_base_sensor) wanted.insert(label);
  LabelCheck labels(wanted);
  const auto edit = [&](mrpt::obs::CObservation& o) {
    if (!labels.wants(o.sensorLabel)) return EditResult::kUnchanged;
    o.setSensorPose(toMrpt(T_base_sensor.at(o.sensorLabel)));
    return EditResult::kEdited;
  };
  return rewriteObservations(input, output, options, edit,
                             [&](const RewriteReport&) { labels.requireAll(input); });
}

mrpt::img::TCamera readCalibration(const fs::path& yaml_file) {
  if (!fs::is_regular_file(yaml_file)) throw ConfigError(yaml_file.string() + ": no such file");
  try {
    const auto yaml = mrpt::containers::yaml::FromFile(yaml_file.string());
    const auto camera = mrpt::img::TCamera::FromYAML(yaml);
    if (camera.ncols == 0 || camera.nrows == 0 || !(camera.fx() > 0) || !(camera.fy() > 0) ||
        !std::isfinite(camera.fx() + camera.fy() + camera.cx() + camera.cy()))
      throw ConfigError("image size and focal lengths must be > 0");
    return camera;
  } catch (const std::exception& e) {
    throw ConfigError(yaml_file.string() + ": is no camera calibration: " + mrptReason(e));
  }
}

RewriteReport setCalibration(const fs::path& input, const fs::path& output,
                             const std::string& label, const mrpt::img::TCamera& calibration,
                             const RewriteOptions& options) {
  LabelCheck labels({label});
  std::uint64_t cameras = 0, other_size = 0;
  const auto edit = [&](mrpt::obs::CObservation& o) {
    if (!labels.wants(o.sensorLabel)) return EditResult::kUnchanged;
    if (auto* image = dynamic_cast<mrpt::obs::CObservationImage*>(&o)) {
      image->cameraParams = calibration;
      if (!image->image.isExternallyStored() && (image->image.getWidth() != calibration.ncols ||
                                                 image->image.getHeight() != calibration.nrows))
        ++other_size;
    } else if (auto* range = dynamic_cast<mrpt::obs::CObservation3DRangeScan*>(&o)) {
      range->cameraParamsIntensity = calibration;
    } else {
      return EditResult::kUnchanged;
    }
    ++cameras;
    return EditResult::kEdited;
  };
  auto report = rewriteObservations(input, output, options, edit, [&](const RewriteReport&) {
    labels.requireAll(input);
    if (cameras == 0) throw ConfigError(input.string() + ": '" + label + "' is not a camera");
  });
  if (other_size > 0)
    report.warnings["image whose size is not that of the calibration"] += other_size;
  return report;
}

RewriteReport relabelRawlog(const fs::path& input, const fs::path& output,
                            const std::vector<LabelChange>& changes,
                            const RewriteOptions& options) {
  std::vector<std::uint64_t> times(changes.size(), 0);
  const auto edit = [&](mrpt::obs::CObservation& o) {
    for (std::size_t i = 0; i < changes.size(); ++i) {
      const LabelChange& change = changes[i];
      if (o.sensorLabel != change.from) continue;
      if (!change.class_name.empty() && shortClassName(o) != change.class_name) continue;
      ++times[i];
      o.sensorLabel = change.to;
      return EditResult::kEdited;
    }
    return EditResult::kUnchanged;
  };
  return rewriteObservations(input, output, options, edit, [&](const RewriteReport&) {
    for (std::size_t i = 0; i < changes.size(); ++i)
      if (times[i] == 0)
        throw ConfigError(
            input.string() + ": no observation of '" + changes[i].from + "'" +
            (changes[i].class_name.empty() ? "" : " (" + changes[i].class_name + ")"));
  });
}

}  // namespace dynemo
