// Conversion of MRPT observations, one function and one file per class; register.cpp lists them.
#pragma once

#include <mrpt/obs/CObservation.h>
#include <mrpt/rtti/CObject.h>

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "dynemo/core/error.h"
#include "dynemo/ingest/external_files.h"
#include "dynemo/ingest/ingest_params.h"
#include "dynemo/ingest/sensor_frame.h"
#include "dynemo/ingest/warning_counter.h"

namespace dynemo {

/// What decoding needs besides the observation.
struct DecodeContext {
  const IngestParams& params;
  const std::map<std::string, Pose3>&
      extrinsics;  ///< T_base_sensor by label, overriding the observation's
  const ExternalFiles& files;
  WarningCounter& warnings;
};

/// Why an observation cannot be used, in a few words, and what makes this case special (a file
/// name, …).
struct DecodeFailure {
  // Implicit, so that make_unexpected("reason") reads well.
  DecodeFailure(const char* reason) : what(reason) {}
  DecodeFailure(std::string reason, std::string special = {})
      : what(std::move(reason)), example(std::move(special)) {}
  std::string what;
  std::string example;
};

template <class T>
using Decoder =
    std::function<Expected<T, DecodeFailure>(mrpt::obs::CObservation&, const DecodeContext&)>;

/// The decoders of one role, by MRPT class, in order of preference.
template <class T>
class DecoderTable {
 public:
  struct Entry {
    const mrpt::rtti::TRuntimeClassId* mrpt_class;
    Decoder<T> decode;
    std::function<bool(const mrpt::obs::CObservation&)> applies;  ///< empty: always
  };
  void add(const mrpt::rtti::TRuntimeClassId* mrpt_class, Decoder<T> decode,
           std::function<bool(const mrpt::obs::CObservation&)> applies = nullptr) {
    entries_.push_back({mrpt_class, std::move(decode), std::move(applies)});
  }
  /// Index of the entry for this object, or -1; a smaller index is preferred.
  int find(const mrpt::obs::CObservation& observation) const {
    for (std::size_t i = 0; i < entries_.size(); ++i)
      if (observation.GetRuntimeClass()->derivedFrom(entries_[i].mrpt_class) &&
          (!entries_[i].applies || entries_[i].applies(observation)))
        return static_cast<int>(i);
    return -1;
  }
  const std::vector<Entry>& entries() const { return entries_; }

 private:
  std::vector<Entry> entries_;
};

struct Decoders {
  DecoderTable<Scan> scans;
  DecoderTable<CameraImage> images;
  DecoderTable<OdometryState> odometry;
  /// T_base_entity and the covariance are final; the stamps of the detections are the
  /// observation's.
  DecoderTable<std::vector<ExternalDetection>> detections;
};

/// Every known class.
const Decoders& decoders();

/// A rotation, and a translation within the size of a planet: what corrupt numbers rarely are.
bool isPlausible(const Pose3& pose);

/// Pose of the sensor in the base frame: the override for its label, else the observation's own.
/// Fails when it is not finite.
Expected<Pose3, DecodeFailure> sensorPose(const mrpt::obs::CObservation& observation,
                                          const DecodeContext& context);

Expected<Scan, DecodeFailure> decodePointCloud(mrpt::obs::CObservation& o, const DecodeContext& c);
Expected<Scan, DecodeFailure> decodeVelodyneScan(mrpt::obs::CObservation& o,
                                                 const DecodeContext& c);
Expected<Scan, DecodeFailure> decodeRotatingScan(mrpt::obs::CObservation& o,
                                                 const DecodeContext& c);
Expected<Scan, DecodeFailure> decode3DRangeScan(mrpt::obs::CObservation& o, const DecodeContext& c);
Expected<CameraImage, DecodeFailure> decodeImage(mrpt::obs::CObservation& o,
                                                 const DecodeContext& c);
/// Whether a CObservation3DRangeScan comes with an image of the visible channel.
bool hasVisibleImage(const mrpt::obs::CObservation& o);
Expected<CameraImage, DecodeFailure> decode3DRangeScanImage(mrpt::obs::CObservation& o,
                                                            const DecodeContext& c);
Expected<OdometryState, DecodeFailure> decodeRobotPose(mrpt::obs::CObservation& o,
                                                       const DecodeContext& c);
Expected<OdometryState, DecodeFailure> decodeOdometry2D(mrpt::obs::CObservation& o,
                                                        const DecodeContext& c);
Expected<std::vector<ExternalDetection>, DecodeFailure> decode6DFeatures(mrpt::obs::CObservation& o,
                                                                         const DecodeContext& c);

}  // namespace dynemo
