#include "dynemo/pipeline/slam_pipeline.h"

#include <algorithm>
#include <set>

#include "dynemo/mapping/ground_height.h"
#include "dynemo/mapping/localize.h"
#include "dynemo/mapping/odometry_noise.h"
#include "dynemo/perception/fragments.h"

namespace dynemo {

/// Where the robot is at a frame.
struct SlamPipeline::RobotState {
  Pose3 T_odom_base;
  Pose3 T_map_base;  ///< predicted from the odometry and the drift so far
  std::optional<OdometryState> measured;
};

SlamPipeline::SlamPipeline(const DynemoParams& params, const EntityModels& models)
    : mrpt::system::COutputLogger("dynemo"),
      params_(params),
      policy_(params.keyframes),
      builder_(params.mapping, models),
      optimizer_(params.solver) {
  if (params.loops.enabled) throw ConfigError("loops.enabled: true: this version closes no loops yet");
  if (params.odometry.source == OdometrySource::kLidar) {
    throw ConfigError("odometry.source: lidar: this version has no LiDAR odometry yet; use auto or rawlog");
  }
  for (const std::string& name : params.perception.detectors) {
    detectors_.push_back(entityDetectors().make(name, params.perception, models));
  }
}

SlamPipeline::~SlamPipeline() = default;

void SlamPipeline::process(const SensorFrame& frame, FrameTiming& timing) {
  // Front-end: the entities in view, the robot's motion, and whether the situation changed (Sec. III).
  auto observations = detect(frame, timing);
  const RobotState robot = track(frame, observations, timing);
  const std::uint32_t reasons = decide(frame, robot, observations, timing);

  // Back-end: nodes and constraints of the new keyframe, then everything jointly (Sec. IV).
  if (reasons != 0) {
    map(select(frame, robot, reasons, std::move(observations), timing), timing);
    optimize(frame, timing);
  }
  record(frame, robot);
}

std::vector<EntityObservation> SlamPipeline::detect(const SensorFrame& frame, FrameTiming& timing) {
  const ScopedStage stage(timing, Stage::kDetection);
  std::vector<EntityObservation> all;
  for (const auto& detector : detectors_) {
    auto found = detector->detect(frame);
    all.insert(all.end(), std::make_move_iterator(found.begin()), std::make_move_iterator(found.end()));
  }
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.entity < b.entity; });
  return all;
}

SlamPipeline::RobotState SlamPipeline::track(const SensorFrame& frame,
                                             const std::vector<EntityObservation>& observations, FrameTiming& timing) {
  const ScopedStage stage(timing, Stage::kOdometry);
  RobotState robot;
  robot.measured = frame.odometry;
  if (robot.measured) {
    robot.T_odom_base = robot.measured->T_odom_base;
  } else {
    if (params_.odometry.source == OdometrySource::kRawlog && frames_.empty()) ++warnings_["frame without odometry"];
    // Without odometry the entities in view tell where the robot is, else it is taken to stand still.
    const auto T_map_base = localizeFromEntities(observations, graph_);
    if (T_map_base) {
      robot.T_odom_base = graph_.T_map_odom.inverse() * *T_map_base;
    } else if (!frames_.empty()) {
      robot.T_odom_base = frames_.back().T_odom_base;
    }
  }
  robot.T_map_base = graph_.T_map_odom * robot.T_odom_base;
  if (!frames_.empty()) {
    const Pose3 T_prev_base = frames_.back().T_odom_base.inverse() * robot.T_odom_base;
    path_since_keyframe_m_ += T_prev_base.t.norm();
    path_since_keyframe_rad_ += rotationAngle(T_prev_base);
  }
  return robot;
}

std::uint32_t SlamPipeline::decide(const SensorFrame& frame, const RobotState& robot,
                                   const std::vector<EntityObservation>& observations, FrameTiming& timing) {
  const ScopedStage stage(timing, Stage::kKeyframe);
  return policy_.decide({frame.stamp, robot.T_odom_base, robot.T_map_base, observations}, graph_);
}

KeyframeData SlamPipeline::select(const SensorFrame& frame, const RobotState& robot, std::uint32_t reasons,
                                  std::vector<EntityObservation> observations, FrameTiming& timing) {
  KeyframeData keyframe;
  keyframe.stamp = frame.stamp;
  keyframe.frame_index = frame.index;
  keyframe.reasons = reasons;
  keyframe.T_odom_base = robot.T_odom_base;
  keyframe.T_map_base = robot.T_map_base;
  keyframe.odometry_covariance = odometryCovariance(frame, robot);
  keyframe_odometry_ = robot.measured;
  path_since_keyframe_m_ = path_since_keyframe_rad_ = 0.0;

  if (frame.scan) {
    const ScopedStage stage(timing, Stage::kFragments);
    keyframe.scan = std::make_shared<const Scan>(*frame.scan);
    if (graph_.floors().empty()) keyframe.ground_level_m = groundLevel(frame, robot);
    keyframe.fragments = extractFragments(*frame.scan, observations, params_.perception.fragments);
  }
  if (params_.mapping.keyframe_entity) {
    const ScopedStage stage(timing, Stage::kMapping);
    keyframe.relative_covariance = relativeCovariances(observations, robot, keyframe.odometry_covariance);
    keyframe.observations = std::move(observations);
  }
  return keyframe;
}

Matrix6 SlamPipeline::odometryCovariance(const SensorFrame& frame, const RobotState& robot) const {
  const OdometryNoiseParams& noise = params_.odometry.noise;
  if (noise.source == OdometryNoiseSource::kFitness && frame.scan && !graph_.keyframes().empty()) {
    const CNodeKeyframe& last = *graph_.keyframes().back();
    if (last.scan && robot.measured) {
      return fitnessCovariance(scanFitness(*last.scan, *frame.scan, last.T_odom_base.inverse() * robot.T_odom_base), noise);
    }
  }
  return relativeOdometryCovariance(keyframe_odometry_, robot.measured, path_since_keyframe_m_, path_since_keyframe_rad_,
                                    noise);
}

std::optional<double> SlamPipeline::groundLevel(const SensorFrame& frame, const RobotState& robot) const {
  const auto height_m = groundHeight(*frame.scan, robot.T_map_base.R);
  if (!height_m) return std::nullopt;
  return robot.T_map_base.t.z() + *height_m;
}

std::map<EntityId, Matrix6> SlamPipeline::relativeCovariances(const std::vector<EntityObservation>& observations,
                                                              const RobotState& robot,
                                                              const Matrix6& odometry_covariance) {
  std::map<EntityId, Matrix6> covariances;
  std::vector<const CNodeEntity*> mapped;
  for (const EntityObservation& observation : observations) {
    const CNodeEntity* last = graph_.lastObservation(observation.entity);
    if (last && (mapped.empty() || mapped.back() != last)) mapped.push_back(last);
  }
  if (mapped.empty()) return covariances;

  const CNodeKeyframe& keyframe = *graph_.keyframes().back();
  std::vector<NodeId> nodes = {keyframe.id};
  for (const CNodeEntity* entity : mapped) nodes.push_back(entity->id);
  const auto joint = optimizer_.marginalCovariance(graph_, nodes);
  if (!joint) {
    ++warnings_["no marginal covariance: " + joint.error()];
    return covariances;
  }
  const Matrix6 A = composeJacobianLeft(keyframe.T_map_base().inverse() * robot.T_map_base);
  for (std::size_t i = 0; i < mapped.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(6 * (i + 1));
    MatrixX pair(12, 12);
    pair << joint->block<6, 6>(at, at), joint->block<6, 6>(at, 0), joint->block<6, 6>(0, at), joint->block<6, 6>(0, 0);
    const Matrix6 to_keyframe = relativePoseCovariance(mapped[i]->T_map_entity(), keyframe.T_map_base(), pair);
    covariances[mapped[i]->entity] = A * to_keyframe * A.transpose() + odometry_covariance;
  }
  return covariances;
}

void SlamPipeline::map(const KeyframeData& keyframe, FrameTiming& timing) {
  const ScopedStage stage(timing, Stage::kMapping);
  graph_.apply(builder_.build(graph_, keyframe));
  logFmt(mrpt::system::LVL_DEBUG, "keyframe %zu at %s: %s, %zu entities", graph_.keyframes().size(),
         keyframe.stamp.text().c_str(), keyframeReasonText(keyframe.reasons).c_str(), keyframe.observations.size());
}

void SlamPipeline::optimize(const SensorFrame& frame, FrameTiming& timing) {
  const ScopedStage stage(timing, Stage::kOptimization);
  runOptimizer(frame.index, frame.stamp);
}

void SlamPipeline::runOptimizer(std::uint64_t frame_index, Stamp stamp) {
  OptimizationReport report = optimizer_.optimize(graph_);
  if (!report.usable()) {
    ++warnings_["optimisation failed: " + report.message];
    logFmt(mrpt::system::LVL_WARN, "optimisation failed at %s: %s", stamp.text().c_str(), report.message.c_str());
  }
  optimizations_.push_back({frame_index, stamp, std::move(report)});
  const CNodeKeyframe& newest = *graph_.keyframes().back();
  graph_.T_map_odom = (newest.T_map_base() * newest.T_odom_base.inverse()).normalized();
}

void SlamPipeline::record(const SensorFrame& frame, const RobotState& robot) {
  frames_.push_back({frame.stamp, robot.T_odom_base, graph_.T_map_odom * robot.T_odom_base});
  keyframe_of_frame_.push_back(graph_.keyframes().size() - 1);
}

void SlamPipeline::finish() {
  if (graph_.keyframes().empty()) return;
  runOptimizer(graph_.keyframes().back()->frame_index, graph_.keyframes().back()->stamp);
  updateTrajectory();
  updateCovariances();
}

void SlamPipeline::updateTrajectory() {
  // Odometry carries a frame forward from the keyframe before it and backward from the one after; the optimised
  // corrections at both ends are blended in between.
  const auto& keyframes = graph_.keyframes();
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    FramePose& frame = frames_[i];
    const CNodeKeyframe& before = *keyframes[keyframe_of_frame_[i]];
    frame.T_map_base = before.T_map_base() * (before.T_odom_base.inverse() * frame.T_odom_base);
    if (keyframe_of_frame_[i] + 1 >= keyframes.size()) continue;
    const CNodeKeyframe& after = *keyframes[keyframe_of_frame_[i] + 1];
    const Pose3 T_from_after = after.T_map_base() * (after.T_odom_base.inverse() * frame.T_odom_base);
    const double span_s = secondsBetween(before.stamp, after.stamp);
    const double s = span_s > 0.0 ? std::clamp(secondsBetween(before.stamp, frame.stamp) / span_s, 0.0, 1.0) : 0.0;
    frame.T_map_base = interpolate(frame.T_map_base, T_from_after, s);
  }
}

void SlamPipeline::updateCovariances() {
  entity_covariances_.clear();
  drift_covariance_.reset();
  std::vector<NodeId> nodes = {graph_.keyframes().back()->id};
  for (const auto& [entity, track] : graph_.tracks()) {
    for (const auto& node : track) nodes.push_back(node->id);
  }
  const auto blocks = optimizer_.marginalBlocks(graph_, nodes);
  if (!blocks) {
    ++warnings_["no marginal covariance: " + blocks.error()];
    return;
  }
  for (std::size_t i = 1; i < nodes.size(); ++i) entity_covariances_[nodes[i]] = (*blocks)[i];
  // T_map_odom = T_map_base · T_base_odom: the keyframe's uncertainty seen from the odometry's origin.
  const Matrix6 A = composeJacobianLeft(graph_.keyframes().back()->T_odom_base.inverse());
  drift_covariance_ = A * (*blocks)[0] * A.transpose();
}

std::map<std::string, std::uint64_t> SlamPipeline::warnings() const {
  auto all = warnings_;
  for (const auto& detector : detectors_) {
    for (const auto& [text, count] : detector->warnings()) all[text] += count;
  }
  return all;
}

}  // namespace dynemo
