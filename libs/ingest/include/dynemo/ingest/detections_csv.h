// Entity detections of any other program, as a table.
#pragma once

#include <filesystem>
#include <istream>
#include <optional>
#include <string>
#include <vector>

#include "dynemo/ingest/sensor_frame.h"
#include "dynemo/ingest/warning_counter.h"

namespace dynemo {

/// One row: a pose of the entity in the sensor's frame, or in the base frame when there is no
/// label.
struct CsvDetection {
  Stamp stamp;
  EntityId entity{};
  std::string class_name;
  Pose3 T_sensor_entity;
  std::string sensor_label;
  /// Of the right tangent of T_sensor_entity.
  std::optional<Matrix6> covariance;
};

/// Reads `timestamp,entity_id,class,x,y,z,qx,qy,qz,qw[,sensor_label[,21 covariance terms]]`:
/// seconds, metres; the upper triangle of the covariance row by row in the order x y z rx ry rz,
/// translation along the axes of the frame the pose is given in, rotation about the entity's own
/// axes. A first line that starts with a letter is a header; empty lines and those that start with
/// # are skipped. Malformed lines are counted with the number of the first. Rows come back sorted
/// by stamp, equal stamps in the order of the file. `origin` names the table in messages. Throws
/// DataError when there is no well-formed row.
std::vector<CsvDetection> readDetectionsCsv(std::istream& in, const std::string& origin,
                                            WarningCounter& warnings);
std::vector<CsvDetection> readDetectionsCsv(const std::filesystem::path& file,
                                            WarningCounter& warnings);

}  // namespace dynemo
