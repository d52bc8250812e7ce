// Random numbers that depend on what they are for, not on the order of the calls.
#pragma once

#include <cstdint>
#include <random>

namespace dynemo::simulation {

/// What a stream of random numbers is for.
enum class Purpose : std::uint64_t { kPlan = 1, kTags, kMotion, kLidar, kCamera, kOdom3d, kOdom2d };

/// SplitMix64.
inline std::uint64_t mixed(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15ULL;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31);
}

class Random {
 public:
  Random(int seed, Purpose purpose, std::uint64_t index = 0)
      : engine_(mixed(
            mixed(mixed(static_cast<std::uint64_t>(seed)) + static_cast<std::uint64_t>(purpose)) +
            index)) {}

  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1.0p-53;
  }
  double normal(double sigma) { return sigma * normal_(engine_); }
  int integer(int low, int high) {
    return low + static_cast<int>(engine_() % static_cast<std::uint64_t>(high - low + 1));
  }
  std::uint64_t bits() { return engine_(); }

 private:
  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_{0.0, 1.0};
};

}  // namespace dynemo::simulation
