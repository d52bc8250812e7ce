#include "dynemo/simulation/camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "random.h"
#include "tag_pattern.h"

namespace dynemo::simulation {
namespace {

using Vector3f = Eigen::Vector3f;
using Pixel = std::uint32_t;  ///< row · width + column

/// Offsets inside a pixel that differ in every row and in every column.
template <int n>
struct SubPixels {
  std::array<Eigen::Vector2f, n> at;
  SubPixels() {
    // Bit reversal: a Hammersley set.
    for (int i = 0; i < n; ++i) {
      int reversed = 0;
      for (int bit = 1, from = i; bit < n; bit *= 2, from /= 2) reversed = 2 * reversed + from % 2;
      at[static_cast<std::size_t>(i)] = {(static_cast<float>(i) + 0.5f) / n - 0.5f,
                                         (static_cast<float>(reversed) + 0.5f) / n - 0.5f};
    }
  }
};

/// Viewing rays (x, y, 1) of all pixels and between them.
class Bearings {
 public:
  explicit Bearings(const CameraSpec& spec) : width_(spec.width), stride_(spec.width + 2) {
    std::vector<cv::Point2d> pixels;
    for (int v = -1; v <= spec.height; ++v)
      for (int u = -1; u <= spec.width; ++u) pixels.emplace_back(u, v);
    const cv::Matx33d K(spec.fx, 0, spec.cx, 0, spec.fy, spec.cy, 0, 0, 1);
    std::vector<cv::Point2d> points;
    cv::undistortPoints(
        pixels, points, K, spec.distortion, cv::noArray(), cv::noArray(),
        cv::TermCriteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 100, 1e-12));
    for (const cv::Point2d& p : points)
      points_.emplace_back(static_cast<float>(p.x), static_cast<float>(p.y));
  }

  Vector3f centre(Pixel pixel) const { return points_[index(pixel)].homogeneous(); }
  Vector3f near(Pixel pixel, const Eigen::Vector2f& offset) const {
    const std::size_t i = index(pixel);
    const Eigen::Vector2f right = 0.5f * (points_[i + 1] - points_[i - 1]);
    const Eigen::Vector2f down = 0.5f * (points_[i + stride_] - points_[i - stride_]);
    return (points_[i] + offset.x() * right + offset.y() * down).homogeneous();
  }

 private:
  std::size_t index(Pixel pixel) const {
    const auto width = static_cast<Pixel>(width_);
    return (pixel / width + 1) * stride_ + pixel % width + 1;
  }
  int width_;
  std::size_t stride_;
  std::vector<Eigen::Vector2f> points_;
};

/// Smooth random brightness on a plane, between −1 and 1.
class NoiseTable {
 public:
  NoiseTable() : values_(kSize * kSize) {
    Random random(0, Purpose::kCamera);
    for (float& v : values_) v = static_cast<float>(random.uniform(-1.0, 1.0));
  }
  float smooth(float x, float y) const {
    const float fx = std::floor(x), fy = std::floor(y);
    const int i = static_cast<int>(fx), j = static_cast<int>(fy);
    const float a = x - fx, b = y - fy;
    const float low = (1 - a) * cell(i, j) + a * cell(i + 1, j);
    const float high = (1 - a) * cell(i, j + 1) + a * cell(i + 1, j + 1);
    return (1 - b) * low + b * high;
  }
  float cell(int i, int j) const {
    return values_[static_cast<std::size_t>((j & (kSize - 1)) * kSize + (i & (kSize - 1)))];
  }

 private:
  static constexpr int kSize = 256;
  std::vector<float> values_;
};

/// A surface as the camera of one image sees it; all in the optical frame.
struct View {
  Vector3f normal, origin, x, y;
  Eigen::Vector2f half;
  Colour colour;
  Texture texture;
  const TagPattern* pattern;
  float offset;  ///< makes the textures of surfaces differ
};

float texture(const NoiseTable& noise, const View& view, float x, float y, float footprint_m) {
  constexpr float kTile_m = 0.6f, kJoint_m = 0.012f;
  x += view.offset;
  switch (view.texture) {
    case Texture::kTiles: {
      const float u = x / kTile_m, v = y / kTile_m;
      const float fu = u - std::floor(u), fv = v - std::floor(v);
      const float tile =
          noise.cell(static_cast<int>(std::floor(u)), static_cast<int>(std::floor(v)));
      const bool joint = fu * kTile_m < kJoint_m || fv * kTile_m < kJoint_m;
      const float sharp = std::clamp(1.5f - footprint_m / kJoint_m, 0.0f, 1.0f);
      const float plain =
          1.0f + 0.1f * tile * std::clamp(1.5f - 2.0f * footprint_m / kTile_m, 0.0f, 1.0f);
      return joint ? plain * (1.0f - 0.4f * sharp) : plain + 0.05f * noise.smooth(9 * x, 9 * y);
    }
    case Texture::kWall:
      return 1.0f + 0.08f * noise.smooth(2.1f * x, 2.1f * y) + 0.04f * noise.smooth(9 * x, 9 * y);
    case Texture::kPanels:
      return 1.0f + 0.1f * noise.smooth(3 * x, 14 * y);
    case Texture::kPlain:
      return 1.0f + 0.06f * noise.smooth(6 * x, 6 * y);
  }
  return 1.0f;
}

std::vector<int> tagsOf(const Scene& scene) {
  std::vector<int> ids;
  for (const Body& body : scene.bodies())
    for (const TagSheet& tag : body.tags) ids.push_back(tag.tag_id);
  return ids;
}

}  // namespace

struct Camera::Impl {
  explicit Impl(const Scene& s)
      : scene(s),
        spec(s.world().sensors.camera),
        T_base_camera(simulation::T_base_camera(spec)),
        snapshot(s.caster()),
        bearings(spec),
        patterns(tagsOf(s)),
        surface_at(static_cast<std::size_t>(spec.width * spec.height)),
        is_edge(surface_at.size()),
        gain(surface_at.size()) {
    const double reach = std::hypot(spec.width, spec.height) / 2.0;
    for (int v = 0; v < spec.height; ++v) {
      for (int u = 0; u < spec.width; ++u) {
        const double r = std::hypot(u - spec.width / 2.0, v - spec.height / 2.0) / reach;
        gain[static_cast<std::size_t>(v * spec.width + u)] =
            static_cast<float>(1.0 - spec.vignetting * r * r);
      }
    }
    constexpr std::size_t kNoiseTable = 1 << 16;
    Random random(scene.world().seed, Purpose::kCamera);
    for (std::size_t i = 0; i < kNoiseTable; ++i)
      noise_table.push_back(static_cast<std::int8_t>(
          std::clamp(std::lround(random.normal(spec.noise)), -127L, 127L)));
    phase = random.uniform(0, 2 * std::numbers::pi);
  }

  void lookAt(double t_s);
  void castPixels(std::span<const Pixel> pixels);
  void findSurfaces();
  void findEdges();
  Colour shade(std::uint32_t surface, const Vector3f& ray) const;
  Colour shadeInside(Pixel pixel) const;
  void shadeEdges(cv::Mat& image, float exposure);
  void addNoise(std::uint64_t index, cv::Mat& image) const;
  void put(cv::Mat& image, Pixel pixel, const Colour& colour, float exposure) const;

  const Scene& scene;
  const CameraSpec& spec;
  Pose3 T_base_camera, T_world_camera;
  RayCaster::Snapshot snapshot;
  Bearings bearings;
  NoiseTable noise;
  TagPatterns patterns;
  SubPixels<8> edge_samples;
  SubPixels<16> tag_samples;

  std::vector<View> views;
  std::vector<std::uint32_t> surface_at;
  std::vector<std::uint8_t> is_edge;
  std::vector<float> gain;
  std::vector<Pixel> pixels;
  std::vector<Ray> rays;
  std::vector<Hit> hits;
  std::vector<std::int8_t> noise_table;
  double phase = 0.0;
};

namespace {
constexpr std::uint32_t kNothing = ~0u, kUnknown = ~0u - 1;
/// Between pixels of the same surface this far apart there is nothing else.
constexpr int kLattice_px = 4;
}  // namespace

/// Poses of everything at an instant, and every surface in the optical frame.
void Camera::Impl::lookAt(double t_s) {
  T_world_camera = scene.robot().at(t_s) * T_base_camera;
  const std::vector<std::vector<Pose3>> instant{scene.entityPoses(t_s)};
  const std::vector<Pose3>& poses = instant.front();
  snapshot.place(instant);
  const Pose3 T_camera_world = T_world_camera.inverse();
  const Vector3 light = Vector3(0.35, 0.2, 0.9).normalized();
  views.clear();
  for (const Surface& surface : scene.caster().surfaces()) {
    const Pose3 T_world_surface = surface.body == 0
                                      ? surface.T_body_surface
                                      : poses[surface.body - 1] * surface.T_body_surface;
    const Pose3 T = T_camera_world * T_world_surface;
    View view;
    view.normal = T.R.col(2).cast<float>();
    view.origin = T.t.cast<float>();
    view.x = T.R.col(0).cast<float>();
    view.y = T.R.col(1).cast<float>();
    view.half = surface.half.cast<float>();
    view.texture = surface.texture;
    view.pattern = surface.tag == nullptr ? nullptr : &patterns.of(surface.tag->tag_id);
    view.offset = static_cast<float>(views.size() % 64) * 3.7f;
    const Vector3 outward = (surface.tag == nullptr ? 1.0 : -1.0) * T_world_surface.R.col(2);
    const double brightness = 0.72 + 0.28 * std::abs(outward.dot(light));
    view.colour = static_cast<float>(brightness) * surface.colour;
    views.push_back(view);
  }
}

void Camera::Impl::castPixels(std::span<const Pixel> list) {
  const Eigen::Matrix3f R = T_world_camera.R.cast<float>();
  const Vector3f t = T_world_camera.t.cast<float>();
  rays.clear();
  for (const Pixel pixel : list)
    rays.push_back({t, (R * bearings.centre(pixel)).normalized(), 0.0f});
  hits.resize(rays.size());
  snapshot.cast(rays, hits);
  for (std::size_t i = 0; i < list.size(); ++i)
    surface_at[list[i]] = std::isfinite(hits[i].range_m) ? hits[i].surface : kNothing;
}

void Camera::Impl::findSurfaces() {
  std::fill(surface_at.begin(), surface_at.end(), kUnknown);
  const auto lattice = [](int size) {
    std::vector<int> at;
    for (int i = 0; i < size - 1; i += kLattice_px) at.push_back(i);
    at.push_back(size - 1);
    return at;
  };
  const std::vector<int> us = lattice(spec.width), vs = lattice(spec.height);
  const auto pixel = [this](int u, int v) { return static_cast<Pixel>(v * spec.width + u); };
  pixels.clear();
  for (const int v : vs)
    for (const int u : us) pixels.push_back(pixel(u, v));
  castPixels(pixels);

  pixels.clear();
  for (std::size_t j = 0; j + 1 < vs.size(); ++j) {
    for (std::size_t i = 0; i + 1 < us.size(); ++i) {
      const std::uint32_t corner = surface_at[pixel(us[i], vs[j])];
      const bool uniform = corner == surface_at[pixel(us[i + 1], vs[j])] &&
                           corner == surface_at[pixel(us[i], vs[j + 1])] &&
                           corner == surface_at[pixel(us[i + 1], vs[j + 1])];
      for (int v = vs[j]; v <= vs[j + 1]; ++v) {
        for (int u = us[i]; u <= us[i + 1]; ++u) {
          std::uint32_t& surface = surface_at[pixel(u, v)];
          if (surface != kUnknown) continue;
          if (uniform)
            surface = corner;
          else
            pixels.push_back(pixel(u, v));
        }
      }
    }
  }
  std::sort(pixels.begin(), pixels.end());
  pixels.erase(std::unique(pixels.begin(), pixels.end()), pixels.end());
  castPixels(pixels);
}

void Camera::Impl::findEdges() {
  std::fill(is_edge.begin(), is_edge.end(), std::uint8_t{0});
  const auto width = static_cast<std::size_t>(spec.width);
  const auto compare = [this](std::size_t a, std::size_t b) {
    if (surface_at[a] != surface_at[b]) is_edge[a] = is_edge[b] = 1;
  };
  for (std::size_t i = 0; i < surface_at.size(); ++i) {
    if ((i + 1) % width != 0) compare(i, i + 1);
    if (i + width < surface_at.size()) compare(i, i + width);
  }
}

Colour Camera::Impl::shade(std::uint32_t surface, const Vector3f& ray) const {
  if (surface == kNothing) return Colour::Constant(0.02f);
  const View& view = views[surface];
  const float facing = view.normal.dot(ray);
  const float s = view.normal.dot(view.origin) / facing;
  const Vector3f p = s * ray - view.origin;
  const float x = view.x.dot(p), y = view.y.dot(p);
  if (view.pattern != nullptr) {
    const float cells = 0.5f * kSheetCells;
    const int column =
        std::clamp(static_cast<int>(cells * (x / view.half.x() + 1.0f)), 0, kSheetCells - 1);
    const int row =
        std::clamp(static_cast<int>(cells * (y / view.half.y() + 1.0f)), 0, kSheetCells - 1);
    return (*view.pattern)[static_cast<std::size_t>(row * kSheetCells + column)]
               ? view.colour
               : 0.1f * view.colour;
  }
  const float footprint_m =
      s * ray.squaredNorm() / (static_cast<float>(spec.fx) * std::max(std::abs(facing), 1e-3f));
  return texture(noise, view, x, y, footprint_m) * view.colour;
}

Colour Camera::Impl::shadeInside(Pixel pixel) const {
  const std::uint32_t surface = surface_at[pixel];
  if (surface == kNothing || views[surface].pattern == nullptr)
    return shade(surface, bearings.centre(pixel));
  Colour sum = Colour::Zero();
  for (const auto& offset : tag_samples.at) sum += shade(surface, bearings.near(pixel, offset));
  return sum / static_cast<float>(tag_samples.at.size());
}

void Camera::Impl::put(cv::Mat& image, Pixel pixel, const Colour& colour, float exposure) const {
  std::uint8_t* out = image.data + 3 * static_cast<std::size_t>(pixel);
  const Colour bright = 255.0f * exposure * gain[pixel] * colour;
  for (int c = 0; c < 3; ++c)
    out[c] = static_cast<std::uint8_t>(std::clamp(bright[c] + 0.5f, 0.0f, 255.0f));
}

void Camera::Impl::shadeEdges(cv::Mat& image, float exposure) {
  pixels.clear();
  for (std::size_t i = 0; i < is_edge.size(); ++i)
    if (is_edge[i]) pixels.push_back(static_cast<Pixel>(i));
  const Eigen::Matrix3f R = T_world_camera.R.cast<float>();
  const Vector3f t = T_world_camera.t.cast<float>();
  constexpr std::size_t kSamples = 8;
  rays.clear();
  for (const Pixel pixel : pixels)
    for (const auto& offset : edge_samples.at)
      rays.push_back({t, (R * bearings.near(pixel, offset)).normalized(), 0.0f});
  hits.resize(rays.size());
  snapshot.cast(rays, hits);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    Colour sum = Colour::Zero();
    for (std::size_t k = 0; k < kSamples; ++k) {
      const Hit& hit = hits[kSamples * i + k];
      sum += shade(std::isfinite(hit.range_m) ? hit.surface : kNothing,
                   bearings.near(pixels[i], edge_samples.at[k]));
    }
    put(image, pixels[i], sum / static_cast<float>(kSamples), exposure);
  }
}

void Camera::Impl::addNoise(std::uint64_t index, cv::Mat& image) const {
  Random random(scene.world().seed, Purpose::kCamera, index + 1);
  const std::size_t mask = noise_table.size() - 1;
  for (int v = 0; v < image.rows; ++v) {
    std::uint8_t* row = image.ptr(v);
    std::size_t at = random.bits() & mask;
    for (int u = 0; u < image.cols; ++u, at = (at + 1) & mask) {
      for (int c = 0; c < 3; ++c, ++row)
        *row = static_cast<std::uint8_t>(std::clamp(*row + noise_table[at], 0, 255));
    }
  }
}

Camera::Camera(const Scene& scene) : impl_(std::make_unique<Impl>(scene)) {}
Camera::~Camera() = default;

cv::Mat Camera::image(std::uint64_t index, double t_s) {
  Impl& m = *impl_;
  m.lookAt(t_s);
  m.findSurfaces();
  m.findEdges();
  constexpr double kExposurePeriod_s = 17.0;
  const auto exposure = static_cast<float>(
      1.0 +
      m.spec.exposure_drift * std::sin(2.0 * std::numbers::pi * t_s / kExposurePeriod_s + m.phase));
  cv::Mat image(m.spec.height, m.spec.width, CV_8UC3);
  for (std::size_t i = 0; i < m.surface_at.size(); ++i) {
    const auto pixel = static_cast<Pixel>(i);
    if (!m.is_edge[i]) m.put(image, pixel, m.shadeInside(pixel), exposure);
  }
  m.shadeEdges(image, exposure);
  if (m.spec.blur_px > 0.0) cv::GaussianBlur(image, image, cv::Size(3, 3), m.spec.blur_px);
  if (m.scene.world().sensors.noise) m.addNoise(index, image);
  return image;
}

}  // namespace dynemo::simulation
