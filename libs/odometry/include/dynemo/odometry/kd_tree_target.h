// Exact nearest neighbours among the points of one scan.
#pragma once

#include <memory>

#include "dynemo/odometry/registration_target.h"
#include "dynemo/odometry/surface_points.h"

namespace dynemo {

/// A k-d tree over surface points, whatever their times. Finds the nearest point the gate allows at
/// any distance.
class KdTreeTarget final : public RegistrationTarget {
 public:
  explicit KdTreeTarget(SurfacePoints surface);
  ~KdTreeTarget() override;
  KdTreeTarget(const KdTreeTarget&) = delete;
  KdTreeTarget& operator=(const KdTreeTarget&) = delete;

  bool nearest(const Eigen::Vector3f& p, const Eigen::Vector3f& normal,
               const CorrespondenceGate& gate, Correspondence& found) const override;

 private:
  struct Impl;
  std::unique_ptr<const Impl> impl_;
};

}  // namespace dynemo
