#include "sample_runs.h"

#include "dynemo/evaluation/trajectory_error.h"
#include "dynemo/ingest/rawlog_source.h"

namespace dynemo::test {

void OdometryErrorScale::apply(SensorFrame& frame) {
  apply(frame.stamp, frame.odometry);
  for (CameraImage& image : frame.images) apply(image.stamp, image.odometry);
}

void OdometryErrorScale::apply(Stamp stamp, std::optional<OdometryState>& odometry) {
  const auto T_world_base = poseAt(truth_, stamp);
  if (!odometry || !T_world_base) return;
  if (!T_odom_world_) T_odom_world_ = odometry->T_odom_base * T_world_base->inverse();
  const Pose3 T_odom_true = *T_odom_world_ * *T_world_base;
  odometry->T_odom_base = T_odom_true.retract(factor_ * local(T_odom_true, odometry->T_odom_base));
}

double SampleRun::ate_m() const {
  Trajectory estimate;
  for (const FramePose& frame : pipeline->frames())
    estimate.push_back({frame.stamp, frame.T_map_base});
  return absoluteTranslationError(alignTrajectories(truth, estimate).value()).rmse;
}

LoopReport SampleRun::loops(const CandidateParams& gate) const {
  std::vector<LoopEstimate> loops;
  for (const LoopRecord& record : pipeline->loops()) {
    if (record.decision == LoopDecision::kAccepted) {
      loops.push_back({*record.edge, record.earlier_stamp, record.later_stamp,
                       record.match->T_target_source, false});
    } else if (record.decision == LoopDecision::kRemoved) {
      for (LoopEstimate& loop : loops) loop.removed = loop.removed || loop.edge == *record.edge;
    }
  }
  Trajectory keyframes;
  for (const auto& keyframe : pipeline->graph().keyframes())
    keyframes.push_back({keyframe->stamp, keyframe->T_map_base()});
  return evaluateLoops(loops, keyframes, truth,
                       LoopGate{gate.max_distance_m, gate.min_path_m, gate.spacing_m});
}

SampleRun runSample(const std::filesystem::path& samples, const std::string& name,
                    const DynemoParams& params, double odometry_error_factor) {
  const auto folder = samples / name;
  SampleRun run;
  run.models =
      std::make_unique<EntityModels>(EntityModels::load(folder / (name + "_entities.yaml")));
  run.truth = readTum(folder / (name + "_gt_robot.tum"));
  const auto source = makeRawlogSource(params.sensors, folder / (name + ".rawlog"));
  run.pipeline = std::make_unique<SlamPipeline>(params, *run.models, source->hasOdometry());
  OdometryErrorScale scale(run.truth, odometry_error_factor);
  while (auto frame = source->next()) {
    if (odometry_error_factor != 1.0) scale.apply(*frame);
    FrameTiming timing;
    run.pipeline->process(std::move(*frame), timing);
  }
  run.pipeline->finish();
  return run;
}

}  // namespace dynemo::test
