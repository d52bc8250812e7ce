// set-extrinsics, set-calibration and relabel.
#include <mrpt/containers/yaml.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationImage.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <string>

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

namespace {

/// Control characters do not occur in text; MRPT's parser would print its complaint about them.
bool isText(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  return std::none_of(bytes.begin(), bytes.end(), [](unsigned char c) {
    return c < 0x20 && c != '\n' && c != '\r' && c != '\t';
  });
}

}  // namespace

mrpt::img::TCamera readCalibration(const fs::path& yaml_file) {
  if (!fs::exists(yaml_file)) throw ConfigError(yaml_file.string() + ": no such file");
  if (fs::is_directory(yaml_file)) throw ConfigError(yaml_file.string() + ": is a folder");
  if (!isText(yaml_file))
    throw ConfigError(yaml_file.string() + ": is no camera calibration: it is no text");
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

namespace {

/// The change that applies to an observation; null for none.
const LabelChange* changeOf(const mrpt::obs::CObservation& o,
                            const std::vector<LabelChange>& changes) {
  const auto found = std::find_if(changes.begin(), changes.end(), [&](const LabelChange& change) {
    return o.sensorLabel == change.from &&
           (change.class_name.empty() || shortClassName(o) == change.class_name);
  });
  return found == changes.end() ? nullptr : &*found;
}

void requireApplied(const fs::path& input, const std::vector<LabelChange>& changes,
                    const std::set<const LabelChange*>& applied) {
  for (const LabelChange& change : changes)
    if (!applied.contains(&change))
      throw ConfigError(input.string() + ": no observation of '" + change.from + "'" +
                        (change.class_name.empty() ? "" : " (" + change.class_name + ")"));
}

}  // namespace

RewriteReport relabelRawlog(const fs::path& input, const fs::path& output,
                            const std::vector<LabelChange>& changes, SameLabel same_label,
                            const RewriteOptions& options) {
  std::set<const LabelChange*> applied;
  // Of each label of the result, those it comes from.
  std::map<std::string, std::set<std::string>> origins;
  const auto edit = [&](mrpt::obs::CObservation& o) {
    const LabelChange* change = changeOf(o, changes);
    origins[change ? change->to : o.sensorLabel].insert(o.sensorLabel);
    if (!change) return EditResult::kUnchanged;
    applied.insert(change);
    o.sensorLabel = change->to;
    return EditResult::kEdited;
  };
  return rewriteObservations(input, output, options, edit, [&](const RewriteReport&) {
    requireApplied(input, changes, applied);
    if (same_label == SameLabel::kMerge) return;
    for (const LabelChange& change : changes) {
      if (origins[change.to].size() < 2) continue;
      std::string labels;
      for (const std::string& from : origins[change.to])
        labels += (labels.empty() ? "'" : "', '") + from;
      throw ConfigError(input.string() + ": " + labels + "' would all be '" + change.to +
                        "', and nothing could tell them apart; choose another label, or merge them "
                        "with --merge");
    }
  });
}

}  // namespace dynemo
