// Whole runs over the sample recordings, with the odometry made worse on purpose.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "dynemo/evaluation/loop_error.h"
#include "dynemo/evaluation/trajectory.h"
#include "dynemo/pipeline/slam_pipeline.h"

namespace dynemo::test {

/// Multiplies the deviation of the frames' odometry from the truth, so that its error is so many
/// times what it was; covariances stay as recorded.
class OdometryErrorScale {
 public:
  OdometryErrorScale(Trajectory truth, double factor) : truth_(std::move(truth)), factor_(factor) {}
  void apply(SensorFrame& frame);

 private:
  void apply(Stamp stamp, std::optional<OdometryState>& odometry);

  Trajectory truth_;
  double factor_;
  /// T_odom_world by the first frame.
  std::optional<Pose3> T_odom_world_;
};

struct SampleRun {
  std::unique_ptr<EntityModels> models;  ///< the pipeline refers to them
  std::unique_ptr<SlamPipeline> pipeline;
  Trajectory truth;

  double ate_m() const;
  /// Judged with the gate of the parameters.
  LoopReport loops(const CandidateParams& gate) const;
};

/// Runs NAME of the samples folder. Loops over the frames as the program does.
SampleRun runSample(const std::filesystem::path& samples, const std::string& name,
                    const DynemoParams& params, double odometry_error_factor = 1.0);

}  // namespace dynemo::test
