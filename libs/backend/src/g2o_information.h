#pragma once

#include "dynemo/core/se3.h"

namespace dynemo {

/// Between the information of [t; q_xyz] and of [t; Log R], see g2o_io.h.
inline Matrix6 fromG2oInformation(const Matrix6& g2o) {
  const Vector6 s = (Vector6() << 1, 1, 1, 0.5, 0.5, 0.5).finished();
  return s.asDiagonal() * g2o * s.asDiagonal();
}
inline Matrix6 toG2oInformation(const Matrix6& ours) {
  const Vector6 s = (Vector6() << 1, 1, 1, 2, 2, 2).finished();
  return s.asDiagonal() * ours * s.asDiagonal();
}

}  // namespace dynemo
