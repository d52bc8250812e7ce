#pragma once

#include "dynemo/perception/plane_extractor.h"

namespace dynemo {

/// Sequential RANSAC on a thinned cloud, with hypotheses from local normals.
class RansacPlanes : public PlaneExtractor {
 public:
  explicit RansacPlanes(const PlaneParams& params) : params_(params) {}
  std::vector<PlaneObservation> extract(const Scan& scan) const override;

 private:
  PlaneParams params_;
};

/// Region growing on the range image; RANSAC for scans that have no rows and columns.
class RangeImagePlanes : public PlaneExtractor {
 public:
  explicit RangeImagePlanes(const PlaneParams& params) : params_(params), without_order_(params) {}
  std::vector<PlaneObservation> extract(const Scan& scan) const override;

 private:
  PlaneParams params_;
  RansacPlanes without_order_;
};

}  // namespace dynemo
