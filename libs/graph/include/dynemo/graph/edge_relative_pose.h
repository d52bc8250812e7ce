#pragma once

#include "dynemo/graph/edge.h"

namespace dynemo {

/// Base of the edges that measure one pose in the frame of another:
///   e = (T_1⁻¹ T_2) ⊟ T_1_2_measured  ∈ R⁶, tangent [x y z rx ry rz] of the measured frame 2.
class CEdgeRelativePose : public CEdgeBase {
  DEFINE_VIRTUAL_SERIALIZABLE(CEdgeRelativePose)
 public:
  Pose3 T_1_2;

  int residualSize() const override { return 6; }
  void evaluate(std::span<const double* const> states, Residual& e, Jacobians* J) const override;

 protected:
  void writeRelativePose(mrpt::serialization::CArchive& out) const;
  void readRelativePose(mrpt::serialization::CArchive& in);
  template <class Edge>
  static std::shared_ptr<Edge> randomExample(std::mt19937_64& rng) {
    auto edge = std::make_shared<Edge>();
    edge->T_1_2 = randomPose(rng);
    edge->setInformation(randomInformation(6, rng));
    return edge;
  }
};

/// Odometry between two consecutive keyframes (nodes: keyframe, keyframe).
class CEdgeOdometry : public CEdgeRelativePose {
  DEFINE_SERIALIZABLE(CEdgeOdometry, dynemo)
 public:
  const char* kind() const override { return "odometry"; }
  static Ptr example(std::mt19937_64& rng) { return randomExample<CEdgeOdometry>(rng); }
};

/// Detection of an entity from a keyframe, x_R⁻¹ ⊕ ε ⊖ ε̃ (paper, Eq. (9); nodes: keyframe, entity).
class CEdgeKeyframeEntity : public CEdgeRelativePose {
  DEFINE_SERIALIZABLE(CEdgeKeyframeEntity, dynemo)
 public:
  const char* kind() const override { return "keyframe_entity"; }
  static Ptr example(std::mt19937_64& rng) { return randomExample<CEdgeKeyframeEntity>(rng); }
};

/// Consecutive observations of one entity under its motion model, ε_{t−1}⁻¹ ⊕ ε_t ⊖ f (paper, Eq.
/// (10); nodes: entity, entity). T_1_2 is f.
class CEdgeIntraEntity : public CEdgeRelativePose {
  DEFINE_SERIALIZABLE(CEdgeIntraEntity, dynemo)
 public:
  /// The motion model that made the edge, e.g. "static_object".
  std::string motion_model;
  const char* kind() const override { return "intra_entity"; }
  static Ptr example(std::mt19937_64& rng) { return randomExample<CEdgeIntraEntity>(rng); }
};

/// Scan matching between two keyframes that are not consecutive (nodes: keyframe, keyframe).
class CEdgeLoopClosure : public CEdgeRelativePose {
  DEFINE_SERIALIZABLE(CEdgeLoopClosure, dynemo)
 public:
  const char* kind() const override { return "loop_closure"; }
  static Ptr example(std::mt19937_64& rng) { return randomExample<CEdgeLoopClosure>(rng); }
};

}  // namespace dynemo
