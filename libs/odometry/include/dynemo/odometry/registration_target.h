// What a scan is registered to.
#pragma once

#include <Eigen/Core>

namespace dynemo {

/// The partner of one scan point.
struct Correspondence {
  Eigen::Vector3f point;
  Eigen::Vector3f normal;
};

/// Which partners are allowed.
struct CorrespondenceGate {
  float max_distance_m = 1.0F;
  /// Cosine between the normals; −1 allows all.
  float min_normal_cosine = -1.0F;
  /// Also looks in the cells that touch by an edge or a corner (methods without cells ignore it).
  bool wide = false;
};

class RegistrationTarget {
 public:
  virtual ~RegistrationTarget() = default;
  /// The nearest allowed point to p; false when there is none. Ties are settled the same way every
  /// time.
  virtual bool nearest(const Eigen::Vector3f& p, const Eigen::Vector3f& normal,
                       const CorrespondenceGate& gate, Correspondence& found) const = 0;
};

}  // namespace dynemo
