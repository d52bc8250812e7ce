#pragma once

#include "dynemo/entities/motion_model.h"

namespace dynemo {

/// Objects rest until moved (paper, Eq. (11)): the identity while P is noise, else P (paper form)
/// or nothing (consistent form: P repeats the two detections).
class ObjectModel : public MotionModel {
 public:
  explicit ObjectModel(const MotionParams& params) : params_(params) {}
  MotionConstraint constrain(const MotionContext& context) const override;

 private:
  MotionParams params_;
};

/// An edge that holds P as it was at creation, weak enough not to count the detections twice.
CEdgeBase::Ptr frozenRelativePose(const MotionContext& context, const MotionParams& params,
                                  const char* model_name);

}  // namespace dynemo
