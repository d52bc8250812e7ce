#include "plane_cache.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <optional>
#include <sstream>
#include <type_traits>

#include "dynemo/core/output_file.h"
#include "record_stream.h"

namespace dynemo {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFormat = "dynemo planes 1";

/// FNV-1a, by words of eight bytes.
class Hash {
 public:
  explicit Hash(std::uint64_t seed = 14695981039346656037ull) : value_(seed) {}

  void add(const void* data, std::size_t size) {
    const char* bytes = static_cast<const char*>(data);
    for (std::size_t at = 0; at < size; at += sizeof(std::uint64_t)) {
      std::uint64_t word = 0;
      std::memcpy(&word, bytes + at, std::min(sizeof word, size - at));
      value_ = (value_ ^ word) * 1099511628211ull;
      value_ ^= value_ >> 32;
    }
    value_ = (value_ ^ size) * 1099511628211ull;
  }
  template <class T>
  void add(const std::vector<T>& values) {
    add(values.data(), values.size() * sizeof(T));
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_;
};

std::uint64_t hashOf(const Scan& scan, std::uint64_t seed) {
  static_assert(sizeof(Eigen::Vector3f) == 3 * sizeof(float));
  Hash hash(seed);
  const PointCloud& cloud = scan.cloud;
  hash.add(cloud.points);
  hash.add(cloud.row);
  hash.add(cloud.column);
  hash.add(&cloud.rows, sizeof cloud.rows);
  hash.add(&cloud.columns, sizeof cloud.columns);
  hash.add(scan.T_base_lidar.R.data(), 9 * sizeof(double));
  hash.add(scan.T_base_lidar.t.data(), 3 * sizeof(double));
  return hash.value();
}

std::string serialized(const std::vector<PlaneObservation>& planes, const fs::path& file) {
  std::ostringstream out;
  RecordWriter writer(out, file);
  writer.text(kFormat);
  writer.put(static_cast<std::uint64_t>(planes.size()));
  for (const PlaneObservation& plane : planes) {
    for (const Vector3& v : {plane.patch_base.center, plane.patch_base.normal})
      writer.put(std::array{v.x(), v.y(), v.z()});
    writer.list(plane.patch_base.cells);
    std::array<double, 9> covariance;
    Eigen::Map<Matrix3>(covariance.data()) = plane.covariance;
    writer.put(covariance);
    writer.put(plane.rms_m);
    writer.list(plane.points);
  }
  return out.str();
}

/// Empty when the file is absent or not whole.
std::optional<std::vector<PlaneObservation>> stored(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return std::nullopt;
  try {
    RecordReader reader(in, file);
    if (reader.text() != kFormat) return std::nullopt;
    std::vector<PlaneObservation> planes;
    for (auto left = reader.get<std::uint64_t>(); left > 0; --left) {
      PlaneObservation plane;
      for (Vector3* v : {&plane.patch_base.center, &plane.patch_base.normal}) {
        const auto xyz = reader.get<std::array<double, 3>>();
        *v = Vector3(xyz[0], xyz[1], xyz[2]);
      }
      plane.patch_base.cells = reader.list<std::array<std::int16_t, 2>>();
      plane.covariance = Eigen::Map<const Matrix3>(reader.get<std::array<double, 9>>().data());
      plane.rms_m = reader.get<double>();
      plane.points = reader.list<std::uint32_t>();
      planes.push_back(std::move(plane));
    }
    return planes;
  } catch (const DataError&) {
    return std::nullopt;
  }
}

}  // namespace

PlaneCache::PlaneCache(fs::path folder, const std::string& identity,
                       std::unique_ptr<PlaneExtractor> inner)
    : folder_(std::move(folder)), inner_(std::move(inner)) {
  Hash hash;
  hash.add(identity.data(), identity.size());
  seed_ = hash.value();
  std::error_code failure;
  fs::create_directories(folder_, failure);
  if (failure) throw DataError(folder_.string() + ": cannot be made: " + failure.message());
}

std::vector<PlaneObservation> PlaneCache::extract(const Scan& scan) const {
  char name[64];
  std::snprintf(name, sizeof name, "%lld_%016llx.planes", static_cast<long long>(scan.stamp.ns),
                static_cast<unsigned long long>(hashOf(scan, seed_)));
  const fs::path file = folder_ / name;
  if (auto known = stored(file)) return *std::move(known);
  auto planes = inner_->extract(scan);
  // Its own name for each process: several may come to the same scan.
  const fs::path own = file.string() + "." + std::to_string(::getpid());
  writeFileAtomically(own, serialized(planes, file));
  std::error_code failure;
  fs::rename(own, file, failure);
  if (failure) throw DataError(file.string() + ": cannot be written: " + failure.message());
  return planes;
}

}  // namespace dynemo
