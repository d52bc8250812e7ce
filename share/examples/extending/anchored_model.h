// A motion model: what is bolted down never moves.
#pragma once

#include "dynemo/core/noise.h"
#include "dynemo/entities/motion_model.h"
#include "dynemo/graph/edge_relative_pose.h"

namespace dynemo {

/// Ties every observation to the previous one without asking whether it moved.
class AnchoredModel : public MotionModel {
 public:
  explicit AnchoredModel(const MotionParams& params) : params_(params) {}

  MotionConstraint constrain(const MotionContext& context) const override {
    auto edge = std::make_shared<CEdgeIntraEntity>();  // T_1_2 is the identity
    edge->nodes = {context.previous().id, context.current.id};
    edge->motion_model = "anchored";
    edge->setCovariance(isotropicCovariance(params_.static_sigma_m, params_.static_sigma_rad));
    return {false, {edge}};
  }

 private:
  MotionParams params_;
};

}  // namespace dynemo
