// Planes grown on the range image: blocks of a few rows and columns are joined while they lie on
// the plane of what was joined so far, then single points at the rim are dealt out.
#include <algorithm>
#include <cmath>
#include <limits>

#include "dynemo/perception/range_image.h"
#include "plane_extractors.h"
#include "plane_fit.h"

namespace dynemo {
namespace {

/// Blocks: small enough to lie on one plane, large enough to tell its direction.
constexpr int kMinBlockRows = 3, kMinBlockColumns = 8, kBlocksUp = 16, kBlocksAround = 64;
constexpr double kMinBlockPoints = 6.0;
/// A block starts a plane when it is this flat, and joins one when its points are this near to it.
constexpr double kSeedSigmas = 1.6, kJoinSigmas = 1.6;
/// A single point belongs to a plane within this distance.
constexpr double kPointSigmas = 3.0;
constexpr double kMinNoise_m = 0.003, kMaxNoise_m = 0.04;
/// So many of the blocks are flatter than the noise estimate.
constexpr double kFlatShare = 0.35;
constexpr std::int32_t kNone = -1;

struct Block {
  Moments moments;
  MomentFit fit;
  std::int32_t region = kNone;
  bool seed = false;
};

class Growth {
 public:
  Growth(const PointCloud& cloud, const RangeImage& image, const PlaneParams& params)
      : cloud_(cloud), image_(image) {
    block_rows_ = std::max(kMinBlockRows, image.rows / kBlocksUp);
    block_columns_ = std::max(kMinBlockColumns, image.columns / kBlocksAround);
    rows_ = (image.rows + block_rows_ - 1) / block_rows_;
    columns_ = (image.columns + block_columns_ - 1) / block_columns_;
    blocks_.resize(static_cast<std::size_t>(rows_ * columns_));
    measureBlocks();
    noise_m_ = params.range_sigma_m ? *params.range_sigma_m : estimatedNoise();
  }

  double noise_m() const { return noise_m_; }

  std::vector<PlaneSegment> run() {
    for (const std::int32_t seed : seeds()) {
      if (block(seed).region == kNone) grow(seed);
    }
    return dealOutPoints();
  }

 private:
  Block& block(std::int32_t i) { return blocks_[static_cast<std::size_t>(i)]; }
  const Block& block(std::int32_t i) const { return blocks_[static_cast<std::size_t>(i)]; }

  /// Calls f(point index) for the points of a block.
  template <class F>
  void forPoints(std::int32_t at, const F& f) const {
    const int row_0 = at / columns_ * block_rows_, column_0 = at % columns_ * block_columns_;
    const int row_1 = std::min(row_0 + block_rows_, image_.rows);
    const int column_1 = std::min(column_0 + block_columns_, image_.columns);
    for (int r = row_0; r < row_1; ++r) {
      for (int c = column_0; c < column_1; ++c) {
        const std::int32_t i = image_.at(r, c);
        if (i >= 0) f(static_cast<std::uint32_t>(i));
      }
    }
  }

  /// The 4 neighbours of a block, or kNone at the rim.
  std::array<std::int32_t, 4> neighbours(std::int32_t at) const {
    const int r = at / columns_, c = at % columns_;
    const auto beside = [&](int column) {
      if (image_.wraps) column = (column + columns_) % columns_;
      return column < 0 || column >= columns_ ? kNone : r * columns_ + column;
    };
    return {r > 0 ? at - columns_ : kNone, r + 1 < rows_ ? at + columns_ : kNone, beside(c - 1),
            beside(c + 1)};
  }

  void measureBlocks() {
    for (std::int32_t b = 0; b < static_cast<std::int32_t>(blocks_.size()); ++b) {
      forPoints(b, [&](std::uint32_t i) { block(b).moments.add(cloud_.points[i].cast<double>()); });
      if (block(b).moments.n >= kMinBlockPoints) block(b).fit = fitMoments(block(b).moments);
    }
  }

  double estimatedNoise() const {
    std::vector<double> rms;
    for (const Block& b : blocks_) {
      if (b.moments.n < 2.0 * kMinBlockPoints) continue;
      // Three parameters were fitted, and the noise is along the ray.
      const double cosine = std::abs(b.fit.plane.normal.dot(b.fit.mean.normalized()));
      rms.push_back(b.fit.rms_m * std::sqrt(b.moments.n / (b.moments.n - 3.0)) /
                    std::max(0.3, cosine));
    }
    if (rms.empty()) return kMinNoise_m;
    const auto at =
        rms.begin() + static_cast<std::ptrdiff_t>(kFlatShare * static_cast<double>(rms.size()));
    std::nth_element(rms.begin(), at, rms.end());
    return std::clamp(*at, kMinNoise_m, kMaxNoise_m);
  }

  /// Flat blocks, those that tell the direction of their plane best first.
  std::vector<std::int32_t> seeds() const {
    std::vector<std::int32_t> list;
    for (std::int32_t b = 0; b < static_cast<std::int32_t>(blocks_.size()); ++b) {
      if (block(b).moments.n >= kMinBlockPoints && block(b).fit.rms_m < kSeedSigmas * noise_m_)
        list.push_back(b);
    }
    const auto certainty = [&](std::int32_t b) {
      return block(b).moments.n * block(b).fit.spread_m2[1];
    };
    std::stable_sort(list.begin(), list.end(),
                     [&](auto a, auto b) { return certainty(a) > certainty(b); });
    return list;
  }

  bool joins(const Block& candidate, const Moments& region, const MomentFit& fit) const {
    if (candidate.moments.n < 1.0) return false;
    const double noise2 = noise_m_ * noise_m_;
    const double uncertainty = std::min(4.0, fit.varianceAt(candidate.moments.mean(), region.n));
    return candidate.moments.meanSquare(fit.plane) <
           noise2 * (kJoinSigmas * kJoinSigmas + uncertainty);
  }

  void grow(std::int32_t seed) {
    const std::int32_t region = static_cast<std::int32_t>(regions_.size());
    Moments sum = block(seed).moments;
    MomentFit fit = block(seed).fit;
    double fitted_n = sum.n;
    std::vector<std::int32_t> members = {seed}, rim = {seed};
    block(seed).region = region;
    // Blocks that did not fit are asked again while the plane still becomes better known.
    for (bool grown = true; grown;) {
      grown = false;
      std::vector<std::int32_t> next_rim;
      for (std::size_t k = 0; k < rim.size(); ++k) {
        bool open = false;
        for (const std::int32_t beside : neighbours(rim[k])) {
          if (beside == kNone || block(beside).region != kNone) continue;
          if (!joins(block(beside), sum, fit)) {
            open = true;
            continue;
          }
          block(beside).region = region;
          members.push_back(beside);
          rim.push_back(beside);
          sum += block(beside).moments;
          grown = true;
          if (sum.n > 1.3 * fitted_n) {
            fit = fitMoments(sum);
            fitted_n = sum.n;
          }
        }
        if (open) next_rim.push_back(rim[k]);
      }
      rim = std::move(next_rim);
      fit = fitMoments(sum);
    }
    if (members.size() < 2 || fit.rms_m > kJoinSigmas * noise_m_) {
      for (const std::int32_t b : members) block(b).region = kNone;
      return;
    }
    regions_.push_back({fit.plane, std::move(members)});
  }

  /// Regions of the block and of those around it, without repetition.
  std::vector<std::int32_t> regionsNear(std::int32_t at) const {
    std::vector<std::int32_t> list;
    const auto note = [&](std::int32_t b) {
      if (b == kNone || block(b).region == kNone) return;
      if (std::find(list.begin(), list.end(), block(b).region) == list.end())
        list.push_back(block(b).region);
    };
    note(at);
    for (const std::int32_t b : neighbours(at)) note(b);
    return list;
  }

  std::vector<PlaneSegment> dealOutPoints() const {
    std::vector<PlaneSegment> segments(regions_.size());
    const double limit_m = kPointSigmas * noise_m_;
    for (std::int32_t b = 0; b < static_cast<std::int32_t>(blocks_.size()); ++b) {
      const std::vector<std::int32_t> near = regionsNear(b);
      if (near.empty()) continue;
      forPoints(b, [&](std::uint32_t i) {
        const Vector3 p = cloud_.points[i].cast<double>();
        double best_m = limit_m;
        std::int32_t best = kNone;
        for (const std::int32_t region : near) {
          const double distance_m =
              std::abs(regions_[static_cast<std::size_t>(region)].plane.distance(p));
          if (distance_m >= best_m) continue;
          best_m = distance_m;
          best = region;
        }
        if (best == kNone) return;
        PlaneSegment& segment = segments[static_cast<std::size_t>(best)];
        segment.points.push_back(i);
        segment.moments.add(p);
      });
    }
    for (PlaneSegment& segment : segments) std::sort(segment.points.begin(), segment.points.end());
    std::erase_if(segments, [](const PlaneSegment& s) { return s.points.size() < 10; });
    return segments;
  }

  struct Region {
    Plane3 plane;
    std::vector<std::int32_t> blocks;
  };

  const PointCloud& cloud_;
  const RangeImage& image_;
  int block_rows_ = 0, block_columns_ = 0, rows_ = 0, columns_ = 0;
  std::vector<Block> blocks_;
  std::vector<Region> regions_;
  double noise_m_ = 0.0;
};

}  // namespace

std::vector<PlaneObservation> RangeImagePlanes::extract(const Scan& scan) const {
  const auto image = rangeImage(scan.cloud);
  if (!image) return without_order_.extract(scan);
  Growth growth(scan.cloud, *image, params_);
  std::vector<PlaneSegment> segments = growth.run();
  return observePlanes(scan, std::move(segments), growth.noise_m(), params_);
}

}  // namespace dynemo
