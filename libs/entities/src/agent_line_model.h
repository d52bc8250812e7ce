#pragma once

#include <optional>

#include "agent_model.h"
#include "dynemo/entities/motion_model.h"

namespace dynemo {

/// Agents on a straight line u (paper, Eq. (13)). Paper form: f = (uuᵀ t_P, I), the other
/// components down-weighted. Consistent form: no displacement across u, measured from the first
/// observation on the line, so that the whole path lies on one line. Until u is known, as
/// AgentModel.
class AgentLineModel : public MotionModel {
 public:
  explicit AgentLineModel(const MotionParams& params) : params_(params), without_line_(params) {}
  MotionConstraint constrain(const MotionContext& context) const override;

 private:
  MotionParams params_;
  AgentModel without_line_;
};

/// Direction (unit vector, map frame) of the straight line through the last positions of a track
/// and the current one, or nothing while they do not spread along one line.
std::optional<Vector3> fitLineDirection(const MotionContext& context, const MotionParams& params);

}  // namespace dynemo
