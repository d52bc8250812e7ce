// A rawlog as a sequence of pieces that can be kept, dropped or edited one by one.
#pragma once

#include <mrpt/obs/CObservation.h>

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "dynemo/core/time.h"
#include "dynemo/ingest/rawlog_reader.h"
#include "dynemo/ingest/warning_counter.h"

namespace dynemo {

/// One object of a rawlog with its bytes. What is not edited is written with the bytes it came
/// with, so that a copy loses nothing.
struct StoredObject {
  RawlogEntry entry;
  bool edited = false;
};

/// The smallest part of a rawlog that makes sense alone: an observation, or the actions that lead
/// to a sensory frame together with it.
struct RawlogPiece {
  std::vector<StoredObject> objects;
  /// Of the observation, or of the first observation in the frame; empty when it is not valid.
  std::optional<Stamp> stamp;
  bool isActionsAndFrame() const;
};

/// What an edit did to an observation.
enum class EditResult { kUnchanged, kEdited, kDropped };
using ObservationEdit = std::function<EditResult(mrpt::obs::CObservation&)>;

/// Applies the edit to each observation of the piece, those in sensory frames included. Returns
/// false when nothing is left of the piece; frames and actions stay even when they become empty,
/// because the odometry is in the actions.
bool editObservations(RawlogPiece& piece, const ObservationEdit& edit);

/// Every observation of the piece.
void forEachObservation(const RawlogPiece& piece,
                        const std::function<void(mrpt::obs::CObservation&)>& visit);

class PieceReader {
 public:
  /// Throws DataError when the file cannot be read at all.
  PieceReader(const std::filesystem::path& rawlog, WarningCounter& warnings);

  /// The next piece, or nothing at the end; damage ends the rawlog with a counted warning. Stored
  /// null objects, which crash other programs, are left out and counted. Throws DataError when the
  /// rawlog holds no object at all.
  std::optional<RawlogPiece> next();

  const std::filesystem::path& file() const { return file_; }
  bool compressed() const { return reader_.compressed(); }
  double fractionRead() const { return reader_.fractionRead(); }

 private:
  std::optional<StoredObject> read();

  std::filesystem::path file_;
  RawlogReader reader_;
  WarningCounter& warnings_;
  std::optional<StoredObject> ahead_;
  bool any_ = false, damage_counted_ = false;
};

}  // namespace dynemo
