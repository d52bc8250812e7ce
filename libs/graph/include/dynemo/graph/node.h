// Nodes of the scene graph: what the back-end estimates.
#pragma once

#include <mrpt/serialization/CSerializable.h>

#include <memory>
#include <random>
#include <string>

#include "dynemo/core/ids.h"
#include "dynemo/core/se3.h"

namespace dynemo {

/// One estimated variable. Its state is a short array of doubles, so that the solver can keep all
/// states in one flat buffer; its tangent is what an optimiser step moves.
class CNodeBase : public mrpt::serialization::CSerializable {
  DEFINE_VIRTUAL_SERIALIZABLE(CNodeBase)
 public:
  NodeId id{};

  virtual int stateSize() const = 0;
  virtual int tangentSize() const = 0;
  /// Copies the current estimate to out[0 … stateSize()).
  virtual void readState(double* out) const = 0;
  /// Replaces the current estimate.
  virtual void writeState(const double* state) = 0;
  /// out = state ⊞ delta; out may be state.
  virtual void retract(const double* state, const double* delta, double* out) const = 0;
  /// Short name for files and pictures: "keyframe", "entity", "floor", …
  virtual const char* kind() const = 0;

 protected:
  void writeBase(mrpt::serialization::CArchive& out) const;
  void readBase(mrpt::serialization::CArchive& in);
};

/// A node whose state is a pose in the map frame: 3 translation, then 9 rotation entries column by
/// column.
class CNodePose : public CNodeBase {
  DEFINE_VIRTUAL_SERIALIZABLE(CNodePose)
 public:
  static constexpr int kStateSize = 12;
  static constexpr int kTangentSize = 6;

  /// Current estimate.
  Pose3 T_map_node;
  /// Estimate when the node was created.
  Pose3 T_map_node_first;

  int stateSize() const override { return kStateSize; }
  int tangentSize() const override { return kTangentSize; }
  void readState(double* out) const override { poseToState(T_map_node, out); }
  void writeState(const double* state) override { T_map_node = poseFromState(state); }
  void retract(const double* state, const double* delta, double* out) const override;

  static Pose3 poseFromState(const double* state);
  static void poseToState(const Pose3& T, double* out);

 protected:
  void writePose(mrpt::serialization::CArchive& out) const;
  void readPose(mrpt::serialization::CArchive& in);
};

}  // namespace dynemo
