#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <memory>
#include <nanoflann.hpp>
#include <random>

#include "plane_extractors.h"
#include "plane_fit.h"

namespace dynemo {
namespace {

constexpr float kLeaf_m = 0.1F;
constexpr std::size_t kNeighbours = 12;
constexpr std::size_t kMinSupport = 25;  ///< of thinned points
constexpr int kHypotheses = 80, kMaxPlanes = 60, kMaxMisses = 3;
constexpr double kInlierSigmas = 3.0;
constexpr double kMinNoise_m = 0.003, kMaxNoise_m = 0.04;
constexpr double kFlatShare = 0.35;
/// Points within this distance of the support belong to it.
constexpr double kSupportReach_m = 0.3;
/// The noise of a plane reaches this many times further than its inliers, and forms no plane.
constexpr double kShadow = 1.7;

/// One point per occupied cell of a grid, with the normal of its surroundings.
struct ThinPoint {
  Eigen::Vector3f p;
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();
  float rms_m = 0.0F;
};

struct Adaptor {
  const std::vector<ThinPoint>& points;
  std::size_t kdtree_get_point_count() const { return points.size(); }
  float kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return points[i].p[static_cast<Eigen::Index>(axis)];
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};
using Tree =
    nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Adaptor>, Adaptor, 3>;

/// One point of each occupied cell: a measured one, since a mean would hide the noise.
std::vector<ThinPoint> thinned(const PointCloud& cloud) {
  using Key = std::array<std::int32_t, 3>;
  std::vector<std::pair<Key, std::uint32_t>> keys;
  keys.reserve(cloud.size());
  for (std::uint32_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Array3f cell = (cloud.points[i].array() / kLeaf_m).floor();
    keys.push_back({{static_cast<std::int32_t>(cell[0]), static_cast<std::int32_t>(cell[1]),
                     static_cast<std::int32_t>(cell[2])},
                    i});
  }
  std::sort(keys.begin(), keys.end());
  std::vector<ThinPoint> thin;
  for (std::size_t k = 0; k < keys.size(); ++k) {
    if (k > 0 && keys[k].first == keys[k - 1].first) continue;
    ThinPoint point;
    point.p = cloud.points[keys[k].second];
    thin.push_back(point);
  }
  return thin;
}

void estimateNormals(std::vector<ThinPoint>& points) {
  const Adaptor adaptor{points};
  const Tree tree(3, adaptor, {16});
  std::vector<std::uint32_t> index(kNeighbours);
  std::vector<float> distance(kNeighbours);
  for (ThinPoint& point : points) {
    const std::size_t found =
        tree.knnSearch(point.p.data(), kNeighbours, index.data(), distance.data());
    Moments moments;
    for (std::size_t k = 0; k < found; ++k)
      moments.add((points[index[k]].p - point.p).cast<double>());
    if (found < 4) continue;
    const MomentFit fit = fitMoments(moments);
    point.normal = fit.plane.normal.cast<float>();
    point.rms_m = static_cast<float>(fit.rms_m);
  }
}

double estimatedNoise(const std::vector<ThinPoint>& points) {
  std::vector<float> rms;
  for (const ThinPoint& p : points) {
    if (!p.normal.isZero()) rms.push_back(p.rms_m);
  }
  if (rms.empty()) return kMinNoise_m;
  const auto at =
      rms.begin() + static_cast<std::ptrdiff_t>(kFlatShare * static_cast<double>(rms.size()));
  std::nth_element(rms.begin(), at, rms.end());
  return std::clamp(static_cast<double>(*at), kMinNoise_m, kMaxNoise_m);
}

/// The thinned points of one plane.
class Support {
 public:
  Support(const std::vector<ThinPoint>& thin, const std::vector<std::uint32_t>& members) {
    Moments moments;
    for (const std::uint32_t i : members) {
      moments.add(thin[i].p.cast<double>());
      points_.push_back(thin[i]);
    }
    plane_ = fitMoments(moments).plane;
    tree_ = std::make_unique<Tree>(3, adaptor_, nanoflann::KDTreeSingleIndexAdaptorParams(16));
  }
  Support(const Support&) = delete;
  Support& operator=(const Support&) = delete;

  const Plane3& plane() const { return plane_; }
  bool reaches(const Eigen::Vector3f& p, double height_m) const {
    if (std::abs(plane_.distance(p.cast<double>())) > height_m) return false;
    std::uint32_t index = 0;
    float distance_m2 = 0.0F;
    tree_->knnSearch(p.data(), 1, &index, &distance_m2);
    return distance_m2 <= kSupportReach_m * kSupportReach_m;
  }

 private:
  std::vector<ThinPoint> points_;
  Adaptor adaptor_{points_};
  Plane3 plane_;
  std::unique_ptr<Tree> tree_;
};

/// Thinned points that are not on a plane yet.
class Search {
 public:
  Search(const std::vector<ThinPoint>& points, double inlier_m, double max_gap_m)
      : points_(points),
        inlier_m_(static_cast<float>(inlier_m)),
        max_gap_m_(static_cast<float>(max_gap_m)) {
    for (std::uint32_t i = 0; i < points.size(); ++i) {
      if (!points[i].normal.isZero()) left_.push_back(i);
    }
  }

  /// The thinned points of the best supported plane, or none.
  std::vector<std::uint32_t> next() {
    if (left_.size() < kMinSupport) return {};
    Eigen::Vector4f best = Eigen::Vector4f::Zero();
    std::size_t best_support = 0;
    for (int h = 0; h < kHypotheses; ++h) {
      const ThinPoint& seed = points_[left_[random_() % left_.size()]];
      Eigen::Vector4f plane;
      plane << seed.normal, -seed.normal.dot(seed.p);
      const std::size_t support = count(plane);
      if (support > best_support) {
        best_support = support;
        best = plane;
      }
    }
    std::vector<std::uint32_t> inliers = inliersOf(best);
    for (int i = 0; i < 3 && inliers.size() >= kMinSupport; ++i)
      inliers = inliersOf(refined(inliers));
    return largestPart(inliers);
  }

  /// Takes out what belongs to a plane, and its noise on both sides.
  void remove(const Support& support) {
    std::erase_if(left_, [&](std::uint32_t i) {
      return support.reaches(points_[i].p, kShadow * static_cast<double>(inlier_m_));
    });
  }

 private:
  bool fits(const ThinPoint& point, const Eigen::Vector4f& plane) const {
    return std::abs(plane.head<3>().dot(point.p) + plane[3]) <= inlier_m_ &&
           std::abs(plane.head<3>().dot(point.normal)) >= kMinCosine;
  }
  std::size_t count(const Eigen::Vector4f& plane) const {
    std::size_t n = 0;
    for (const std::uint32_t i : left_) n += fits(points_[i], plane) ? 1 : 0;
    return n;
  }
  std::vector<std::uint32_t> inliersOf(const Eigen::Vector4f& plane) const {
    std::vector<std::uint32_t> list;
    for (const std::uint32_t i : left_) {
      if (fits(points_[i], plane)) list.push_back(i);
    }
    return list;
  }
  Eigen::Vector4f refined(const std::vector<std::uint32_t>& inliers) const {
    Moments moments;
    for (const std::uint32_t i : inliers) moments.add(points_[i].p.cast<double>());
    const MomentFit fit = fitMoments(moments);
    Eigen::Vector4f plane;
    plane << fit.plane.normal.cast<float>(), static_cast<float>(fit.plane.d_m);
    return plane;
  }

  /// The largest group of inliers without a gap.
  std::vector<std::uint32_t> largestPart(const std::vector<std::uint32_t>& inliers) const {
    std::vector<std::int32_t> group(inliers.size(), -1);
    std::vector<std::uint32_t> best;
    const float gap2 = max_gap_m_ * max_gap_m_;
    for (std::size_t seed = 0; seed < inliers.size(); ++seed) {
      if (group[seed] >= 0) continue;
      std::vector<std::size_t> members = {seed};
      group[seed] = static_cast<std::int32_t>(seed);
      for (std::size_t k = 0; k < members.size(); ++k) {
        for (std::size_t other = 0; other < inliers.size(); ++other) {
          if (group[other] >= 0) continue;
          if ((points_[inliers[members[k]]].p - points_[inliers[other]].p).squaredNorm() > gap2)
            continue;
          group[other] = static_cast<std::int32_t>(seed);
          members.push_back(other);
        }
      }
      if (members.size() <= best.size()) continue;
      std::sort(members.begin(), members.end());
      best.clear();
      for (const std::size_t m : members) best.push_back(inliers[m]);
    }
    return best;
  }

  static constexpr float kMinCosine = 0.93F;  // of an angle of 0.37 rad
  const std::vector<ThinPoint>& points_;
  float inlier_m_, max_gap_m_;
  std::vector<std::uint32_t> left_;
  std::mt19937 random_{1};
};

/// All points of the scan near a plane and near its support, each on one plane only.
PlaneSegment claim(const PointCloud& cloud, const Support& support, double inlier_m,
                   std::vector<char>& free) {
  PlaneSegment segment;
  for (std::uint32_t i = 0; i < cloud.size(); ++i) {
    if (!free[i] || !support.reaches(cloud.points[i], kShadow * inlier_m)) continue;
    free[i] = 0;
    const Vector3 p = cloud.points[i].cast<double>();
    if (std::abs(support.plane().distance(p)) > inlier_m) continue;
    segment.points.push_back(i);
    segment.moments.add(p);
  }
  return segment;
}

}  // namespace

std::vector<PlaneObservation> RansacPlanes::extract(const Scan& scan) const {
  std::vector<ThinPoint> thin = thinned(scan.cloud);
  if (thin.size() < kMinSupport) return {};
  estimateNormals(thin);
  const double noise_m = params_.range_sigma_m ? *params_.range_sigma_m : estimatedNoise(thin);
  const double inlier_m = kInlierSigmas * noise_m;
  Search search(thin, inlier_m, params_.max_gap_m);
  std::vector<PlaneSegment> segments;
  std::vector<char> free(scan.cloud.size(), 1);
  for (int plane = 0, misses = 0; plane < kMaxPlanes && misses < kMaxMisses; ++plane) {
    const std::vector<std::uint32_t> members = search.next();
    if (members.size() < kMinSupport) {
      ++misses;
      continue;
    }
    const Support support(thin, members);
    search.remove(support);
    PlaneSegment segment = claim(scan.cloud, support, inlier_m, free);
    if (segment.points.size() >= 10) segments.push_back(std::move(segment));
  }
  return observePlanes(scan, std::move(segments), noise_m, params_);
}

}  // namespace dynemo
