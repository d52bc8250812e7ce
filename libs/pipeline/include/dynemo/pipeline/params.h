// The whole configuration of a run: the sections of config/default.yaml.
#pragma once

#include <string>
#include <vector>

#include "dynemo/backend/optimizer.h"
#include "dynemo/core/fields.h"
#include "dynemo/exporters/export_params.h"
#include "dynemo/ingest/ingest_params.h"
#include "dynemo/life/life_params.h"
#include "dynemo/loops/loop_params.h"
#include "dynemo/mapping/delta_builder.h"
#include "dynemo/mapping/keyframe_policy.h"
#include "dynemo/mapping/odometry_noise.h"
#include "dynemo/odometry/odometry_params.h"
#include "dynemo/perception/perception_params.h"
#include "dynemo/pipeline/agent_points.h"
#include "dynemo/pipeline/frame_refinement.h"

namespace dynemo {

enum class OdometrySource {
  kAuto,    ///< the rawlog's when it carries any, else estimated from the scans
  kRawlog,  ///< the rawlog's; an error when it carries none
  kLidar    ///< estimated from the scans
};

struct RobotOdometryParams {
  OdometrySource source = OdometrySource::kAuto;
  OdometryNoiseParams noise;
  OdometryParams lidar;
  AgentPointsParams agents;
};
void fields(FieldVisitor& v, RobotOdometryParams& p);

struct DynemoParams {
  IngestParams sensors;
  RobotOdometryParams odometry;
  PerceptionParams perception;
  KeyframeParams keyframes;
  MappingParams mapping;
  LoopParams loops;
  LifeParams life;
  SolverParams solver;
  FrameRefinementParams trajectory;
  /// Registered exporters whose files the run folder gets.
  std::vector<std::string> outputs = {"trajectory", "keyframes", "odometry", "entities", "planes",
                                      "g2o",        "graph",     "3dscene",  "map",      "session"};
  ExportParams exports;
  /// Results so far are written every so many seconds of the dataset, for runs that get killed.
  double checkpoint_s = 60.0;
};
void fields(FieldVisitor& v, DynemoParams& p);

}  // namespace dynemo
