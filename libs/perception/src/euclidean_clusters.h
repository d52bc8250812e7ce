#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "dynemo/core/point_cloud.h"

namespace dynemo {

/// Groups of points connected by gaps of at most `tolerance_m`, found with a KD-tree over cells
/// much smaller than the tolerance. Each point is in exactly one group; indices ascending, groups
/// in order of their first point.
std::vector<PointIndices> euclideanClusters(std::span<const Eigen::Vector3f> points,
                                            float tolerance_m);

}  // namespace dynemo
