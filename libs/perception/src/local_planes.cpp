#include "local_planes.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <random>
#include <set>

namespace dynemo {
namespace {

using Eigen::Vector3f;

constexpr int kHypotheses = 60;
/// More points than this do not make a hypothesis more certain.
constexpr std::size_t kMaxSample = 400;
constexpr std::size_t kMinSupport = 12;
constexpr float kMaxGroundTilt_rad = 0.2F;
constexpr float kGroundSearch_m = 0.3F;  ///< around the expected height
/// How many times the points of the ground outnumber those of an equal slice above it.
constexpr float kGroundContrast = 1.5F;
constexpr float kMaxWallLean_rad = 0.2F;
constexpr float kBin_m = 0.1F;
constexpr int kMaxWalls = 3;

/// A uniform draw in [0, n) that is the same with every standard library.
std::size_t draw(std::mt19937& generator, std::size_t n) { return generator() % n; }

std::vector<Vector3f> thin(const std::vector<Vector3f>& points) {
  const std::size_t stride = points.size() / kMaxSample + 1;
  std::vector<Vector3f> sample;
  for (std::size_t i = 0; i < points.size(); i += stride) sample.push_back(points[i]);
  return sample;
}

std::size_t countInliers(std::span<const Vector3f> points, const LocalPlane& plane,
                         float tolerance) {
  return static_cast<std::size_t>(
      std::count_if(points.begin(), points.end(),
                    [&](const Vector3f& p) { return std::abs(plane.distance(p)) <= tolerance; }));
}

/// Least squares through the points near the plane; the plane itself when they are too few or on a
/// line.
LocalPlane refit(std::span<const Vector3f> points, const LocalPlane& plane, float tolerance) {
  Vector3f sum = Vector3f::Zero();
  Eigen::Matrix3f squares = Eigen::Matrix3f::Zero();
  float n = 0.0F;
  for (const Vector3f& p : points) {
    if (std::abs(plane.distance(p)) > tolerance) continue;
    sum += p;
    squares += p * p.transpose();
    n += 1.0F;
  }
  if (n < static_cast<float>(kMinSupport)) return plane;
  const Vector3f mean = sum / n;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> eigen(squares / n - mean * mean.transpose());
  const float on_a_line = 0.1F * tolerance;
  if (!(eigen.eigenvalues()[1] > on_a_line * on_a_line)) return plane;
  LocalPlane fitted;
  fitted.normal = eigen.eigenvectors().col(0);
  if (fitted.normal.dot(plane.normal) < 0.0F) fitted.normal = -fitted.normal;
  fitted.offset = -fitted.normal.dot(mean);
  return fitted;
}

struct Hypothesis {
  LocalPlane plane;
  std::size_t support = 0;
};

/// The best supported of planes through drawn points; `propose` returns nothing for a useless draw.
template <class Propose>
Hypothesis consensus(std::span<const Vector3f> sample, float tolerance, const Propose& propose) {
  std::mt19937 generator(1);
  Hypothesis best;
  for (int i = 0; i < kHypotheses; ++i) {
    const std::optional<LocalPlane> plane = propose(generator);
    if (!plane) continue;
    const std::size_t support = countInliers(sample, *plane, tolerance);
    if (support > best.support) best = {*plane, support};
  }
  return best;
}

std::optional<LocalPlane> planeThrough(const Vector3f& on_plane, const Vector3f& normal) {
  const float length = normal.norm();
  if (!(length > 1e-3F)) return std::nullopt;
  return LocalPlane{normal / length, -normal.dot(on_plane) / length};
}

/// Level enough, and not just a slice through upright faces, of which the next slice above would
/// hold as much.
bool isGround(std::span<const Vector3f> points, const LocalPlane& plane, float tolerance) {
  if (plane.normal.z() < std::cos(kMaxGroundTilt_rad)) return false;
  const LocalPlane above{plane.normal, plane.offset - 2.0F * tolerance};
  return static_cast<float>(countInliers(points, plane, tolerance)) >
         kGroundContrast * static_cast<float>(countInliers(points, above, tolerance));
}

float lowHeight(std::span<const Vector3f> points) {
  constexpr std::size_t kOneIn = 50;  // a few returns below the ground are noise
  std::vector<float> heights;
  for (const Vector3f& p : points) heights.push_back(p.z());
  const auto low = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / kOneIn);
  std::nth_element(heights.begin(), low, heights.end());
  return *low;
}

/// How much of the plane's horizontal direction its points cover [m].
float coveredLength(std::span<const Vector3f> points, const std::vector<char>& keep,
                    const LocalPlane& plane, const Vector3f& along, float tolerance) {
  std::set<int> bins;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (keep[i] && std::abs(plane.distance(points[i])) <= tolerance) {
      bins.insert(static_cast<int>(std::floor(along.dot(points[i]) / kBin_m)));
    }
  }
  return kBin_m * static_cast<float>(bins.size());
}

std::vector<Vector3f> selected(std::span<const Vector3f> points, const std::vector<char>& keep) {
  std::vector<Vector3f> result;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (keep[i]) result.push_back(points[i]);
  }
  return result;
}

/// The best supported upright plane.
Hypothesis findUprightPlane(std::span<const Vector3f> sample, const Vector3f& up, float tolerance) {
  return consensus(sample, tolerance, [&](std::mt19937& generator) {
    const Vector3f& a = sample[draw(generator, sample.size())];
    const Vector3f& b = sample[draw(generator, sample.size())];
    return planeThrough(a, (b - a).cross(up));
  });
}

}  // namespace

LocalPlane findGround(std::span<const Vector3f> points, std::optional<double> expected_height_m,
                      const FragmentParams& params) {
  LocalPlane level;
  if (points.empty()) return level;
  level.offset = expected_height_m ? -static_cast<float>(*expected_height_m) : -lowHeight(points);
  std::vector<Vector3f> low;
  for (const Vector3f& p : points) {
    if (std::abs(level.distance(p)) <= kGroundSearch_m) low.push_back(p);
  }
  if (low.size() < kMinSupport) return level;
  const std::vector<Vector3f> sample = thin(low);
  const auto tolerance = static_cast<float>(params.ground_tolerance_m);
  const Hypothesis best = consensus(sample, tolerance, [&](std::mt19937& generator) {
    const Vector3f& a = sample[draw(generator, sample.size())];
    const Vector3f& b = sample[draw(generator, sample.size())];
    const Vector3f& c = sample[draw(generator, sample.size())];
    auto plane = planeThrough(a, (b - a).cross(c - a));
    if (plane && plane->normal.z() < 0.0F) *plane = {-plane->normal, -plane->offset};
    if (plane && plane->normal.z() < std::cos(kMaxGroundTilt_rad)) plane.reset();
    return plane;
  });
  if (best.support < kMinSupport) return level;
  const LocalPlane fitted = refit(low, best.plane, tolerance);
  return isGround(low, fitted, tolerance) ? fitted : level;
}

void dropWalls(std::span<const Vector3f> points, const Vector3f& up, const FragmentParams& params,
               std::vector<char>& keep) {
  const auto tolerance = static_cast<float>(params.plane_tolerance_m);
  for (int i = 0; i < kMaxWalls; ++i) {
    const std::vector<Vector3f> sample = thin(selected(points, keep));
    if (sample.size() < kMinSupport) return;
    const Hypothesis best = findUprightPlane(sample, up, tolerance);
    if (best.support < kMinSupport) return;
    const LocalPlane wall = refit(sample, best.plane, tolerance);
    if (std::abs(wall.normal.dot(up)) > std::sin(kMaxWallLean_rad)) return;
    const Vector3f along = up.cross(wall.normal).normalized();
    if (coveredLength(points, keep, wall, along, tolerance) <
        static_cast<float>(params.plane_min_length_m)) {
      return;
    }
    for (std::size_t k = 0; k < points.size(); ++k) {
      if (std::abs(wall.distance(points[k])) <= tolerance) keep[k] = 0;
    }
  }
}

}  // namespace dynemo
