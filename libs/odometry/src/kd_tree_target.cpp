#include "dynemo/odometry/kd_tree_target.h"

#include <nanoflann.hpp>

namespace dynemo {
namespace {

struct Cloud {
  const std::vector<Eigen::Vector3f>& points;
  std::size_t kdtree_get_point_count() const { return points.size(); }
  float kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return points[i][static_cast<Eigen::Index>(axis)];
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Cloud>, Cloud,
                                                 3, std::uint32_t>;

/// nanoflann's result set of one point: starts at the gate's distance, so that the search does not
/// go beyond it, and turns away points that face elsewhere. Of points visited at one distance the
/// lower index wins.
class NearestAllowed {
 public:
  using DistanceType = float;

  NearestAllowed(const SurfacePoints& surface, const Eigen::Vector3f& normal,
                 const CorrespondenceGate& gate)
      : surface_(surface),
        normal_(normal),
        min_cosine_(gate.min_normal_cosine),
        distance2_(gate.max_distance_m * gate.max_distance_m) {}

  bool addPoint(float distance2, std::uint32_t index) {
    if (distance2 > distance2_ || (distance2 == distance2_ && index >= index_)) return true;
    if (surface_.normals[index].dot(normal_) < min_cosine_) return true;
    distance2_ = distance2;
    index_ = index;
    return true;
  }
  float worstDist() const { return distance2_; }
  bool full() const { return true; }
  std::size_t size() const { return found() ? 1 : 0; }
  bool found() const { return index_ != kNone; }
  std::uint32_t index() const { return index_; }

 private:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;

  const SurfacePoints& surface_;
  const Eigen::Vector3f& normal_;
  float min_cosine_;
  float distance2_;
  std::uint32_t index_ = kNone;
};

}  // namespace

struct KdTreeTarget::Impl {
  explicit Impl(SurfacePoints points)
      : surface(std::move(points)), cloud{surface.points}, tree(3, cloud) {}

  SurfacePoints surface;
  Cloud cloud;
  Tree tree;
};

KdTreeTarget::KdTreeTarget(SurfacePoints surface)
    : impl_(std::make_unique<const Impl>(std::move(surface))) {}

KdTreeTarget::~KdTreeTarget() = default;

bool KdTreeTarget::nearest(const Eigen::Vector3f& p, const Eigen::Vector3f& normal,
                           const CorrespondenceGate& gate, Correspondence& found) const {
  NearestAllowed result(impl_->surface, normal, gate);
  impl_->tree.findNeighbors(result, p.data(), nanoflann::SearchParams());
  if (!result.found()) return false;
  found = {impl_->surface.points[result.index()], impl_->surface.normals[result.index()]};
  return true;
}

}  // namespace dynemo
