// TagSLAM's test recordings: tag corners found in real images by other detectors, with calibration
// and reference.
//
// Tags are there seen upright with x right, y up and z out of the tag; everything here is turned
// into the convention of TagModel. The order of the corners is the same in both.
#pragma once

#include <filesystem>
#include <map>
#include <ostream>
#include <string>
#include <vector>

#include "dynemo/perception/pose_ambiguity.h"
#include "dynemo/perception/tag_pose.h"

namespace dynemo::test {

struct TagslamCamera {
  std::string name;  ///< "cam0"
  std::string tag_topic;
  CameraModel model;
  Pose3 T_rig_camera;
};

/// All tags that one camera saw at one instant.
struct TagslamFrame {
  Stamp stamp;
  std::size_t camera = 0;  ///< index into cameras
  std::vector<TagCornerObservation> tags;
};

struct TagslamDataset {
  std::vector<TagslamCamera> cameras;
  std::vector<TagslamFrame> frames;  ///< by stamp, then camera
  /// T_parent_child of the reference's last instant, by child frame ("cube", "tag_3").
  std::map<std::string, Pose3> reference_last;
  /// T_map_body by stamp, by body.
  std::map<std::string, std::map<Stamp, Pose3>> reference_tracks;
  std::map<int, double> tag_size_m;  ///< of the tags that the reference knows

  /// One entity that carries the reference's tags of one body.
  EntityModel bodyAsEntity(EntityId id) const;
  /// Each tag an entity of its own, with the tag's id, at the tag's centre.
  EntityModels tagsAsEntities() const;
};

/// Reads a folder tagslam/test_N. Throws DataError when it cannot be read.
TagslamDataset readTagslam(const std::filesystem::path& folder);

/// Detections of all entities in all frames as the lines of a detection file: pose in the rig
/// frame, no sensor label. Poses that stay ambiguous are left out.
void writeDetections(const TagslamDataset& dataset, const EntityModels& models,
                     const TagPoseParams& pose, const AmbiguityParams& ambiguity,
                     std::ostream& out);

}  // namespace dynemo::test
