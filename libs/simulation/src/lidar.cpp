#include "dynemo/simulation/lidar.h"

#include <cmath>
#include <numbers>

#include "random.h"

namespace dynemo::simulation {
namespace {

/// Drop-outs, lost grazing returns, noise and rounding of one sweep.
class ReturnModel {
 public:
  ReturnModel(const LidarSpec& spec, bool noise, Random random)
      : spec_(spec),
        noise_(noise),
        random_(std::move(random)),
        sin_grazing_(std::sin(spec.grazing_rad)) {}

  /// Measured range; empty when there is no return. `sin_incidence`: 1 when the beam hits squarely.
  std::optional<double> measure(double range_m, double sin_incidence) {
    if (range_m < spec_.min_range_m || range_m > spec_.max_range_m) return std::nullopt;
    if (!noise_) return range_m;
    if (random_.uniform(0, 1) < spec_.dropout) return std::nullopt;
    if (sin_incidence < sin_grazing_ && random_.uniform(0, 1) < 0.5) return std::nullopt;
    return range_m + random_.normal(spec_.sigma_m);
  }

  float rounded(double coordinate_m) const {
    if (!noise_ || spec_.quantum_m <= 0.0) return static_cast<float>(coordinate_m);
    return static_cast<float>(std::round(coordinate_m / spec_.quantum_m) * spec_.quantum_m);
  }

 private:
  const LidarSpec& spec_;
  bool noise_;
  Random random_;
  double sin_grazing_;
};

}  // namespace

Lidar::Lidar(const Scene& scene)
    : scene_(scene),
      spec_(scene.world().sensors.lidar),
      T_base_lidar_(T_base_lidar(spec_)),
      snapshot_(scene.caster()) {
  for (int ring = 0; ring < spec_.rings; ++ring) {
    const double elevation = spec_.elevation_rad(ring);
    for (int column = 0; column < spec_.columns; ++column) {
      const double azimuth = std::numbers::pi * (2.0 * spec_.turned(column) - 1.0);
      directions_.push_back(Vector3(std::cos(elevation) * std::cos(azimuth),
                                    std::cos(elevation) * std::sin(azimuth), std::sin(elevation))
                                .cast<float>());
    }
  }
  rays_.resize(directions_.size());
  hits_.resize(directions_.size());
}

void Lidar::aim(double t_s) {
  const auto columns = static_cast<std::size_t>(spec_.columns);
  Pose3 T_world_lidar = scene_.robot().at(t_s) * T_base_lidar_;
  for (std::size_t c = 0; c < columns; ++c) {
    const double turned = spec_.turned(static_cast<int>(c));
    if (spec_.motion_distortion)
      T_world_lidar = scene_.robot().at(t_s + turned / spec_.rate_hz) * T_base_lidar_;
    const Eigen::Matrix3f R = T_world_lidar.R.cast<float>();
    const Eigen::Vector3f t = T_world_lidar.t.cast<float>();
    for (std::size_t i = c; i < rays_.size(); i += columns)
      rays_[i] = {t, R * directions_[i], static_cast<float>(turned)};
  }
}

Sweep Lidar::sweep(std::uint64_t index, double t_s) {
  std::vector<std::vector<Pose3>> instants{scene_.entityPoses(t_s)};
  if (spec_.motion_distortion) {
    // Fine enough that a turning person is off by less than a millimetre in between.
    constexpr int kSteps = 8;
    for (int k = 1; k <= kSteps; ++k)
      instants.push_back(scene_.entityPoses(t_s + k / (kSteps * spec_.rate_hz)));
  }
  snapshot_.place(instants);
  aim(t_s);
  snapshot_.cast(rays_, hits_);

  const World& world = scene_.world();
  ReturnModel returns(spec_, world.sensors.noise, Random(world.seed, Purpose::kLidar, index));
  const auto& surfaces = scene_.caster().surfaces();
  Sweep sweep;
  sweep.points.reserve(rays_.size());
  for (std::size_t i = 0; i < rays_.size(); ++i) {
    if (!std::isfinite(hits_[i].range_m)) continue;
    const Surface& surface = surfaces[hits_[i].surface];
    Vector3 normal = surface.T_body_surface.R.col(2);
    if (surface.body > 0) normal = instants.front()[surface.body - 1].R * normal;
    const auto range_m =
        returns.measure(hits_[i].range_m, std::abs(normal.dot(rays_[i].direction.cast<double>())));
    if (!range_m) continue;
    const Vector3 p = *range_m * directions_[i].cast<double>();
    sweep.points.emplace_back(returns.rounded(p.x()), returns.rounded(p.y()),
                              returns.rounded(p.z()));
    sweep.ring.push_back(static_cast<std::uint16_t>(i / static_cast<std::size_t>(spec_.columns)));
    sweep.column.push_back(static_cast<std::uint16_t>(i % static_cast<std::size_t>(spec_.columns)));
    sweep.range_m.push_back(static_cast<float>(*range_m));
  }
  return sweep;
}

}  // namespace dynemo::simulation
