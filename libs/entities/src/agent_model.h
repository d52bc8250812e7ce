#pragma once

#include "dynemo/entities/motion_model.h"

namespace dynemo {

/// Agents without a known path (paper, Eq. (12)): P frozen at creation (paper form), or a slowly
/// changing velocity over the last three observations (consistent form).
class AgentModel : public MotionModel {
 public:
  explicit AgentModel(const MotionParams& params) : params_(params) {}
  MotionConstraint constrain(const MotionContext& context) const override;

 private:
  MotionParams params_;
};

}  // namespace dynemo
