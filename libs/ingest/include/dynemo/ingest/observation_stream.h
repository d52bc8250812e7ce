// The usable observations of a rawlog of either format, in the order of the file.
#pragma once

#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CSensoryFrame.h>

#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "dynemo/ingest/decoders.h"
#include "dynemo/ingest/rawlog_reader.h"
#include "dynemo/ingest/timed_item.h"

namespace dynemo {

class ActionOdometry;

/// Flattens sensory frames, turns odometry actions into cumulative odometry, and gives every
/// observation that has a decoder its role. An action's motion ends at the first stamp of the
/// sensory frame that follows it, as everywhere in MRPT, or at its own stamp when none follows.
/// What cannot be used is counted.
class ObservationStream {
 public:
  /// Label of the odometry that comes from actions.
  static constexpr const char* kActionsLabel = "actions";

  /// Throws DataError when the file cannot be read at all.
  ObservationStream(const std::filesystem::path& rawlog, const DecodeContext& context);
  ~ObservationStream();

  /// Nothing at the end of what can be read; the reader then says whether the file was damaged.
  std::optional<TimedItem> next();

  const RawlogReader& reader() const { return reader_; }
  /// Observations read, by "label (class)".
  const std::map<std::string, std::uint64_t>& observations() const { return observations_; }
  /// T_base_sensor of the sensors seen so far, by label.
  const std::map<std::string, Pose3>& sensorPoses() const { return sensor_poses_; }

 private:
  void take(const RawlogEntry& entry);
  void takeObservation(const mrpt::obs::CObservation::Ptr& observation);
  void takeFrame(const mrpt::obs::CSensoryFrame& frame);
  void takeActions(const mrpt::obs::CActionCollection& actions);
  void takeOdometry(mrpt::obs::CObservation& observation, Stamp stamp, int rank);
  void takeDetections(mrpt::obs::CObservation& observation, Stamp stamp);
  void emitActionOdometry(Stamp stamp);
  void flushPendingAction();

  DecodeContext context_;
  RawlogReader reader_;
  std::deque<TimedItem> ready_;
  std::map<std::string, std::uint64_t> observations_;
  std::map<std::string, Pose3> sensor_poses_;

  std::unique_ptr<ActionOdometry> action_odometry_;
  bool actions_seen_ = false;
  bool action_pending_ = false;  ///< applied, but its end is not known yet
  std::optional<Stamp> action_stamp_, last_frame_stamp_;
};

}  // namespace dynemo
