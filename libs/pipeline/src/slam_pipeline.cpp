#include "dynemo/pipeline/slam_pipeline.h"

#include <algorithm>
#include <utility>

#include "dynemo/life/keyframe_retention.h"
#include "dynemo/life/removal.h"
#include "dynemo/life/settling.h"
#include "dynemo/loops/without_closures.h"
#include "dynemo/mapping/ground_plane.h"
#include "dynemo/odometry/deskew.h"
#include "dynemo/perception/fragments.h"
#include "dynemo/pipeline/doubts.h"

namespace dynemo {
namespace {

/// As a robot at rest at the scan's stamp would have measured it.
Scan still(const Scan& scan, const SweepMotion& motion) {
  Scan result = scan;
  result.cloud = deskew(scan.cloud, scan.T_base_lidar, motion, 0.0);
  return result;
}

}  // namespace

SlamPipeline::SlamPipeline(const DynemoParams& params, const EntityModels& models,
                           bool rawlog_odometry)
    : mrpt::system::COutputLogger("dynemo"),
      params_(params),
      entities_described_(!models.empty()),
      tracker_(params.odometry, rawlog_odometry, params.perception.planes,
               params.mapping.sweep_distortion),
      agent_points_(params.odometry.agents),
      plane_extractor_(
          planeExtractors().make(params.perception.planes.extractor, params.perception.planes)),
      policy_(params.keyframes),
      builder_(params.mapping, models),
      loops_(params.loops),
      optimizer_(params.solver) {
  for (const std::string& name : params.perception.detectors) {
    detectors_.push_back(entityDetectors().make(name, params.perception, models));
  }
}

SlamPipeline::~SlamPipeline() = default;

void SlamPipeline::useCache(FrontEndCache& cache) {
  tracker_.useCache(cache);
  for (auto& detector : detectors_) detector = cache.wrap(std::move(detector));
  plane_extractor_ = cache.wrap(std::move(plane_extractor_));
}

void SlamPipeline::process(SensorFrame frame, FrameTiming& timing) {
  // Front-end: the robot's motion, the entities in view, and whether the situation changed (Sec.
  // III).
  auto observations = look(frame, timing);
  const Pose3 T_odom_base = locate(frame, observations, timing);
  addWaiting(timing);
  const RobotState robot{T_odom_base, graph_.T_map_odom * T_odom_base};
  const std::uint32_t reasons = decide(frame, robot, observations, timing);
  if (reasons == 0) {
    return record(frame, robot, {tracker_.stepCovariance(), sightingsOf(observations)});
  }

  Chosen chosen = choose(std::move(frame), robot, reasons, std::move(observations));
  if (waitsForNext(chosen)) {
    waiting_ = std::move(chosen);
  } else {
    add(std::move(chosen), timing);
  }
}

// Back-end: nodes and constraints of the new keyframe, then everything jointly (Sec. IV).
void SlamPipeline::add(Chosen chosen, FrameTiming& timing) {
  map(select(chosen, timing), timing);
  closeLoops(timing);
  makeRoom(timing);
  optimize(chosen.frame, timing);
  record(chosen.frame, chosen.robot, {chosen.step_covariance, {}});
}

void SlamPipeline::addWaiting(FrameTiming& timing) {
  if (!waiting_) return;
  Chosen chosen = *std::exchange(waiting_, std::nullopt);
  if (tracker_.motionSinceLast()) chosen.motion = tracker_.motionSinceLast();
  add(std::move(chosen), timing);
}

bool SlamPipeline::waitsForNext(const Chosen& chosen) const {
  return params_.keyframes.deskew == KeyframeDeskew::kNextFrame && chosen.frame.scan &&
         !chosen.frame.scan->cloud.time_offset_s.empty() && !tracker_.knowsSweepMotion();
}

std::vector<EntityObservation> SlamPipeline::look(SensorFrame& frame, FrameTiming& timing) {
  if (!params_.odometry.agents.left_out) {
    estimateMotion(frame, {}, timing);
    return detect(frame, timing);
  }
  tracker_.predict(frame);
  auto observations = detect(frame, timing);
  estimateMotion(frame, agent_points_.of(frame, observations), timing);
  if (frame.odometry)
    agent_points_.remember(frame.stamp, frame.odometry->T_odom_base, observations);
  return observations;
}

void SlamPipeline::estimateMotion(SensorFrame& frame, const PointIndices& ignored,
                                  FrameTiming& timing) {
  const ScopedStage stage(timing, Stage::kOdometry);
  tracker_.estimate(frame, ignored);
}

std::vector<EntityObservation> SlamPipeline::detect(const SensorFrame& frame, FrameTiming& timing) {
  const ScopedStage stage(timing, Stage::kDetection);
  std::vector<EntityObservation> all;
  for (const auto& detector : detectors_) {
    auto found = detector->detect(frame);
    all.insert(all.end(), std::make_move_iterator(found.begin()),
               std::make_move_iterator(found.end()));
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.entity < b.entity; });
  return all;
}

Pose3 SlamPipeline::locate(const SensorFrame& frame,
                           const std::vector<EntityObservation>& observations,
                           FrameTiming& timing) {
  const ScopedStage stage(timing, Stage::kOdometry);
  return tracker_.locate(frame, observations, graph_);
}

std::uint32_t SlamPipeline::decide(const SensorFrame& frame, const RobotState& robot,
                                   const std::vector<EntityObservation>& observations,
                                   FrameTiming& timing) {
  const ScopedStage stage(timing, Stage::kKeyframe);
  return policy_.decide({frame.stamp, robot.T_odom_base, robot.T_map_base, observations}, graph_);
}

SlamPipeline::Chosen SlamPipeline::choose(SensorFrame frame, const RobotState& robot,
                                          std::uint32_t reasons,
                                          std::vector<EntityObservation> observations) {
  const Matrix6 odometry_covariance = tracker_.covarianceSinceKeyframe(frame, graph_);
  tracker_.keyframeMade(frame);
  return {std::move(frame),
          robot,
          reasons,
          std::move(observations),
          odometry_covariance,
          tracker_.stepCovariance(),
          tracker_.sweepMotion()};
}

KeyframeData SlamPipeline::select(Chosen& chosen, FrameTiming& timing) {
  KeyframeData keyframe;
  keyframe.stamp = chosen.frame.stamp;
  keyframe.frame_index = chosen.frame.index;
  keyframe.reasons = chosen.reasons;
  keyframe.T_odom_base = chosen.robot.T_odom_base;
  keyframe.T_map_base = chosen.robot.T_map_base;
  keyframe.odometry_covariance = chosen.odometry_covariance;

  if (chosen.frame.scan) {
    keyframe.scan = std::make_shared<const Scan>(
        params_.keyframes.deskew != KeyframeDeskew::kNone && chosen.motion
            ? still(*chosen.frame.scan, *chosen.motion)
            : *chosen.frame.scan);
    {
      const ScopedStage stage(timing, Stage::kFragments);
      keyframe.fragments =
          extractFragments(*keyframe.scan, chosen.observations, params_.perception.fragments);
    }
    const ScopedStage stage(timing, Stage::kPlanes);
    seePlanes(*keyframe.scan, keyframe);
  }
  const ScopedStage stage(timing, Stage::kMapping);
  if (params_.mapping.keyframe_entity) keyframe.observations = std::move(chosen.observations);
  associate(keyframe);
  return keyframe;
}

void SlamPipeline::seePlanes(const Scan& scan, KeyframeData& keyframe) const {
  keyframe.planes = plane_extractor_->extract(scan);
  std::erase_if(keyframe.planes, [&](const PlaneObservation& plane) {
    return std::any_of(keyframe.fragments.begin(), keyframe.fragments.end(),
                       [&](const PointIndices& fragment) { return isFaceOf(plane, fragment); });
  });
  const auto base_height_m = baseHeight(graph_);
  keyframe.ground = findGround(keyframe.planes, keyframe.T_map_base.R,
                               base_height_m ? std::optional(-*base_height_m) : std::nullopt);
}

std::optional<KeyframePrediction> SlamPipeline::predict(const KeyframeData& keyframe) {
  if (graph_.keyframes().empty()) return std::nullopt;
  std::vector<NodeId> nodes;
  if (params_.mapping.planes.enabled) {
    nodes = planeCandidates(graph_, keyframe.T_map_base, keyframe.planes,
                            params_.mapping.planes.association);
  }
  for (const EntityObservation& observation : keyframe.observations) {
    const CNodeEntity* last = graph_.lastObservation(observation.entity);
    if (last && (nodes.empty() || nodes.back() != last->id)) nodes.push_back(last->id);
  }
  if (nodes.empty()) return std::nullopt;
  std::vector<NodeId> with_keyframe = {graph_.keyframes().back()->id};
  with_keyframe.insert(with_keyframe.end(), nodes.begin(), nodes.end());
  const auto joint = optimizer_.marginalCovariance(graph_, with_keyframe);
  if (!joint) {
    ++warnings_["no marginal covariance: " + joint.error()];
    return std::nullopt;
  }
  return KeyframePrediction(graph_, keyframe.T_map_base, keyframe.odometry_covariance,
                            std::move(nodes), *joint);
}

void SlamPipeline::associate(KeyframeData& keyframe) {
  auto prediction = predict(keyframe);
  if (!prediction) return;
  if (params_.mapping.planes.enabled) {
    keyframe.plane_association =
        associatePlanes(graph_, *prediction, keyframe.planes, params_.mapping.planes.association);
    // What the walls show of a slip must not look like motion of the entities.
    keyframe.odometry_covariance += keyframe.plane_association.slip;
    prediction->widen(keyframe.plane_association.slip);
  }
  for (const EntityObservation& observation : keyframe.observations) {
    const CNodeEntity* last = graph_.lastObservation(observation.entity);
    if (!last) continue;
    const MatrixX joint = prediction->jointWith({last->id});
    MatrixX swapped(12, 12);
    swapped << joint.bottomRightCorner(6, 6), joint.bottomLeftCorner(6, 6),
        joint.topRightCorner(6, 6), joint.topLeftCorner(6, 6);
    keyframe.relative_covariance[observation.entity] =
        relativePoseCovariance(last->T_map_entity(), keyframe.T_map_base, swapped);
  }
}

void SlamPipeline::map(const KeyframeData& keyframe, FrameTiming& timing) {
  const ScopedStage stage(timing, Stage::kMapping);
  graph_.apply(builder_.build(graph_, keyframe));
  trail_.add(*graph_.keyframes().back());
  logFmt(mrpt::system::LVL_DEBUG, "keyframe %zu at %s: %s, %zu entities", graph_.keyframes().size(),
         keyframe.stamp.text().c_str(), keyframeReasonText(keyframe.reasons).c_str(),
         keyframe.observations.size());
}

void SlamPipeline::closeLoops(FrameTiming& timing) {
  const ScopedStage stage(timing, Stage::kLoops);
  const std::size_t decided = loops_.records().size();
  graph_.apply(loops_.close(graph_, optimizer_));
  for (std::size_t i = decided; i < loops_.records().size(); ++i) {
    const LoopRecord& loop = loops_.records()[i];
    logFmt(mrpt::system::LVL_DEBUG, "loop %s - %s: %s %s", loop.earlier_stamp.text().c_str(),
           loop.later_stamp.text().c_str(), loopDecisionName(loop.decision), loop.reason.c_str());
  }
}

void SlamPipeline::makeRoom(FrameTiming& timing) {
  if (!params_.life.bounded) return;
  const ScopedStage stage(timing, Stage::kMapping);
  const std::vector<NodeId> surplus = surplusKeyframes(graph_, params_.life);
  if (surplus.empty()) return;
  trail_.hang(surplus, graph_);
  graph_.apply(settledTies(graph_, params_.life));
  for (const NodeId keyframe : surplus) {
    const GraphDelta delta = removalOf(graph_, keyframe, params_.life);
    loops_.forget(graph_, keyframe);
    graph_.apply(delta);
  }
}

void SlamPipeline::optimize(const SensorFrame& frame, FrameTiming& timing) {
  const ScopedStage stage(timing, Stage::kOptimization);
  recordOptimization(frame.index, frame.stamp, optimizer_.optimize(graph_));
}

void SlamPipeline::recordOptimization(std::uint64_t frame_index, Stamp stamp,
                                      OptimizationReport report) {
  if (!report.usable()) {
    ++warnings_["optimisation failed: " + report.message];
    logFmt(mrpt::system::LVL_WARN, "optimisation failed at %s: %s", stamp.text().c_str(),
           report.message.c_str());
  }
  optimizations_.push_back({frame_index, stamp, std::move(report)});
  const CNodeKeyframe& newest = *graph_.keyframes().back();
  graph_.T_map_odom = (newest.T_map_base() * newest.T_odom_base.inverse()).normalized();
}

void SlamPipeline::record(const SensorFrame& frame, const RobotState& robot,
                          FrameMeasurements measurements) {
  frames_.push_back({frame.stamp, robot.T_odom_base, graph_.T_map_odom * robot.T_odom_base});
  measurements_.push_back(std::move(measurements));
  keyframe_of_frame_.push_back(trail_.size() - 1);
}

void SlamPipeline::finish() {
  FrameTiming untold;
  addWaiting(untold);
  if (graph_.keyframes().empty()) return;
  settleLoops();
  updateTrajectory();
  updateCovariances();
  refineTrajectory();
  for (const std::string& doubt : doubts()) logStr(mrpt::system::LVL_INFO, doubt);
  const auto& outputs = params_.outputs;
  if (loops_.closures() > 0 && std::find(outputs.begin(), outputs.end(), "map") != outputs.end())
    keyframes_without_closures_ = keyframesWithoutClosures(graph_, params_.solver);
}

void SlamPipeline::settleLoops() {
  // Each round takes closures out, so that it comes to an end.
  const CNodeKeyframe& newest = *graph_.keyframes().back();
  GraphDelta taken_out;
  do {
    recordOptimization(newest.frame_index, newest.stamp, optimizer_.optimizeFully(graph_));
    taken_out = loops_.review(graph_);
    graph_.apply(taken_out);
  } while (!taken_out.empty());
}

void SlamPipeline::updateTrajectory() {
  // Odometry carries a frame forward from the keyframe before it and backward from the one after;
  // the optimised corrections at both ends are blended in between.
  const auto carriedFrom = [&](std::size_t keyframe, const FramePose& frame) {
    return trail_.T_map_base(keyframe, graph_) *
           (trail_.T_odom_base(keyframe).inverse() * frame.T_odom_base);
  };
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    FramePose& frame = frames_[i];
    const std::size_t before = keyframe_of_frame_[i], after = before + 1;
    frame.T_map_base = carriedFrom(before, frame);
    if (after >= trail_.size()) continue;
    const Pose3 T_from_after = carriedFrom(after, frame);
    const double span_s = secondsBetween(trail_.stamp(before), trail_.stamp(after));
    const double s =
        span_s > 0.0
            ? std::clamp(secondsBetween(trail_.stamp(before), frame.stamp) / span_s, 0.0, 1.0)
            : 0.0;
    frame.T_map_base = interpolate(frame.T_map_base, T_from_after, s);
  }
}

void SlamPipeline::refineTrajectory() {
  if (!params_.trajectory.objects && !params_.trajectory.acceleration_sigma_m_s2) return;
  for (std::size_t begin = 0; begin < frames_.size();) {
    std::size_t end = begin + 1;
    while (end < frames_.size() && keyframe_of_frame_[end] == keyframe_of_frame_[begin]) ++end;
    const std::size_t count = std::min(end + 1, frames_.size()) - begin;
    // Where the keyframe has left the graph, the places of what was seen then have, too.
    const auto& keyframes = graph_.keyframes();
    const Stamp stamp = trail_.stamp(keyframe_of_frame_[begin]);
    const auto keyframe =
        std::lower_bound(keyframes.begin(), keyframes.end(), stamp,
                         [](const auto& node, Stamp at) { return node->stamp < at; });
    if (keyframe != keyframes.end() && (*keyframe)->stamp == stamp) {
      refineFrames(graph_, static_cast<std::size_t>(keyframe - keyframes.begin()),
                   entity_covariances_, std::span(measurements_).subspan(begin, count),
                   params_.trajectory, std::span(frames_).subspan(begin, count));
    }
    begin = end;
  }
}

void SlamPipeline::updateCovariances() {
  entity_covariances_.clear();
  plane_covariances_.clear();
  drift_covariance_.reset();
  std::vector<NodeId> nodes = {graph_.keyframes().back()->id};
  for (const auto& [entity, track] : graph_.tracks()) {
    for (const auto& node : track) nodes.push_back(node->id);
  }
  const std::size_t planes_begin = nodes.size();
  for (const auto& plane : graph_.planes()) nodes.push_back(plane->id);
  const auto blocks = optimizer_.marginalBlocks(graph_, nodes);
  if (!blocks) {
    ++warnings_["no marginal covariance: " + blocks.error()];
    return;
  }
  for (std::size_t i = 1; i < planes_begin; ++i) entity_covariances_[nodes[i]] = (*blocks)[i];
  for (std::size_t i = planes_begin; i < nodes.size(); ++i)
    plane_covariances_[nodes[i]] = (*blocks)[i];
  // T_map_odom = T_map_base · T_base_odom: the keyframe's uncertainty seen from the odometry's
  // origin.
  const Matrix6 A = composeJacobianLeft(graph_.keyframes().back()->T_odom_base.inverse());
  drift_covariance_ = A * (*blocks)[0] * A.transpose();
}

std::vector<std::string> SlamPipeline::doubts() const {
  RunFacts run;
  run.frames = frames_.size();
  run.guessed_frames = tracker_.guessedFrames();
  run.keyframes = trail_.size();
  run.entities_mapped = params_.mapping.keyframe_entity;
  run.entities_described = entities_described_;
  run.entities = graph_.tracks().size();
  for (const auto& detector : detectors_) {
    const auto unknown = detector->warnings().find(kUnknownEntityWarning);
    if (unknown != detector->warnings().end()) run.unknown_detections += unknown->second;
  }
  return doubtsAbout(run);
}

std::map<std::string, std::uint64_t> SlamPipeline::warnings() const {
  auto all = warnings_;
  for (const auto& [text, count] : tracker_.warnings()) all[text] += count;
  for (const auto& [text, count] : loops_.warnings()) all[text] += count;
  for (const auto& detector : detectors_) {
    for (const auto& [text, count] : detector->warnings()) all[text] += count;
  }
  return all;
}

}  // namespace dynemo
