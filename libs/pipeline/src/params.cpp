#include "dynemo/pipeline/params.h"

namespace dynemo {

void fields(FieldVisitor& v, RobotOdometryParams& p) {
  v.choice("source", p.source, {"auto", "rawlog", "lidar"},
           "The rawlog's when it carries any, always the rawlog's, or estimated from the scans");
  v.section("noise", p.noise, "How uncertain the odometry between two keyframes is");
  v.section("lidar", p.lidar, "Odometry estimated from the scans");
  v.section("agents", p.agents, "What becomes of points on agents in LiDAR odometry");
}

void fields(FieldVisitor& v, DynemoParams& p) {
  v.section("sensors", p.sensors,
            "Which observations of the rawlog are used, and how they are synchronised");
  v.section("odometry", p.odometry, "Where the robot's relative motion comes from");
  v.section("perception", p.perception, "Detection of entities and of their points");
  v.section("keyframes", p.keyframes, "When a frame becomes a keyframe");
  v.section("mapping", p.mapping, "Nodes and edges of the scene graph");
  v.section("loops", p.loops, "Loop closure");
  v.section("life", p.life, "Keyframes that leave the graph");
  v.section("solver", p.solver, "Optimisation of the graph");
  v.section("trajectory", p.trajectory, "Poses of the frames between keyframes");
  v.texts("outputs", p.outputs, "Files written to the output folder");
  v.section("exports", p.exports, "Options of the files in outputs");
  v.number("checkpoint_s", p.checkpoint_s,
           "Results so far are written every so many seconds of the dataset", Range::positive());
}

}  // namespace dynemo
