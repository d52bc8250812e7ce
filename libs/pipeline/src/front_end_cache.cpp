#include "dynemo/pipeline/front_end_cache.h"

#include <unistd.h>

#include <sstream>

#include "dynemo/core/config.h"
#include "dynemo/core/error.h"
#include "plane_cache.h"
#include "record_stream.h"

namespace dynemo {
namespace {

namespace fs = std::filesystem;

/// Changes with the layout of the records.
constexpr const char* kFormat = "dynemo front-end cache 1";
/// Before each record, so that a mix-up is noticed.
constexpr std::uint8_t kOdometryRecord = 'O', kDetectionRecord = 'D', kEnd = 'E';

/// Rotation, then translation; Eigen's matrices are not trivially copyable.
using PoseNumbers = std::array<double, 12>;

PoseNumbers numbers(const Pose3& T) {
  PoseNumbers n;
  Eigen::Map<Matrix3>(n.data()) = T.R;
  Eigen::Map<Vector3>(n.data() + 9) = T.t;
  return n;
}

Pose3 pose(const PoseNumbers& n) {
  return {Matrix3(Eigen::Map<const Matrix3>(n.data())),
          Vector3(Eigen::Map<const Vector3>(n.data() + 9))};
}

std::array<double, 36> numbers(const Matrix6& m) {
  std::array<double, 36> n;
  Eigen::Map<Matrix6>(n.data()) = m;
  return n;
}

Matrix6 matrix(const std::array<double, 36>& n) { return Eigen::Map<const Matrix6>(n.data()); }

std::array<double, 6> numbers(const Vector6& v) {
  std::array<double, 6> n;
  Eigen::Map<Vector6>(n.data()) = v;
  return n;
}

Vector6 vector(const std::array<double, 6>& n) { return Eigen::Map<const Vector6>(n.data()); }

}  // namespace

class FrontEndCache::Odometry : public ScanOdometry {
 public:
  Odometry(FrontEndCache& cache, std::unique_ptr<ScanOdometry> inner)
      : cache_(cache), inner_(std::move(inner)) {}

  Expected<OdometryEstimate, OdometryFailure> update(
      const Scan& scan, const std::optional<OdometryState>& rawlog_odometry,
      std::span<const std::uint32_t> ignored) override {
    if (cache_.replays()) return replay(scan.stamp);
    const auto result = inner_->update(scan, rawlog_odometry, ignored);
    record(scan.stamp, result);
    return result;
  }
  bool measuresSweepMotion() const override { return inner_->measuresSweepMotion(); }

 private:
  void record(Stamp stamp, const Expected<OdometryEstimate, OdometryFailure>& result) {
    cache_.writer_->put(kOdometryRecord);
    cache_.writer_->put(stamp.ns);
    cache_.writer_->put(static_cast<std::uint8_t>(result.has_value()));
    if (!result) return cache_.writer_->put(result.error());
    cache_.writer_->put(result->stamp.ns);
    cache_.writer_->put(numbers(result->T_odom_base));
    cache_.writer_->put(numbers(result->T_prev_base));
    cache_.writer_->put(numbers(result->covariance));
    cache_.writer_->put(numbers(result->motion.twist.vector()));
    cache_.writer_->put(numbers(result->motion.acceleration.vector()));
    cache_.writer_->put(result->restarted);
    cache_.writer_->put(result->diagnostics.points);
    cache_.writer_->put(result->diagnostics.inlier_ratio);
    cache_.writer_->put(result->diagnostics.residual_rms_m);
    cache_.writer_->put(result->diagnostics.iterations);
    const auto& directions = result->diagnostics.degenerate_directions;
    cache_.writer_->put(static_cast<std::uint8_t>(directions.cols()));
    for (Eigen::Index i = 0; i < directions.cols(); ++i)
      cache_.writer_->put(numbers(Vector6(directions.col(i))));
  }

  Expected<OdometryEstimate, OdometryFailure> replay(Stamp stamp) {
    if (cache_.reader_->get<std::uint8_t>() != kOdometryRecord ||
        cache_.reader_->get<std::int64_t>() != stamp.ns)
      throw DataError(cache_.file_.string() + ": belongs to another recording; delete it");
    if (cache_.reader_->get<std::uint8_t>() == 0)
      return make_unexpected(cache_.reader_->get<OdometryFailure>());
    OdometryEstimate e;
    e.stamp.ns = cache_.reader_->get<std::int64_t>();
    e.T_odom_base = pose(cache_.reader_->get<PoseNumbers>());
    e.T_prev_base = pose(cache_.reader_->get<PoseNumbers>());
    e.covariance = matrix(cache_.reader_->get<std::array<double, 36>>());
    e.motion.twist = BodyTwist::fromVector(vector(cache_.reader_->get<std::array<double, 6>>()));
    e.motion.acceleration =
        BodyTwist::fromVector(vector(cache_.reader_->get<std::array<double, 6>>()));
    e.restarted = cache_.reader_->get<bool>();
    e.diagnostics.points = cache_.reader_->get<std::size_t>();
    e.diagnostics.inlier_ratio = cache_.reader_->get<double>();
    e.diagnostics.residual_rms_m = cache_.reader_->get<double>();
    e.diagnostics.iterations = cache_.reader_->get<int>();
    e.diagnostics.degenerate_directions.resize(6, cache_.reader_->get<std::uint8_t>());
    for (Eigen::Index i = 0; i < e.diagnostics.degenerate_directions.cols(); ++i)
      e.diagnostics.degenerate_directions.col(i) =
          vector(cache_.reader_->get<std::array<double, 6>>());
    return e;
  }

  FrontEndCache& cache_;
  std::unique_ptr<ScanOdometry> inner_;
};

class FrontEndCache::Detector : public EntityDetector {
 public:
  Detector(FrontEndCache& cache, std::unique_ptr<EntityDetector> inner)
      : cache_(cache), inner_(std::move(inner)) {}

  std::vector<EntityObservation> detect(const SensorFrame& frame) override {
    if (cache_.replays()) return replay(frame.stamp);
    auto found = inner_->detect(frame);
    warnings_ = inner_->warnings();
    record(frame.stamp, found);
    return found;
  }

 private:
  void record(Stamp stamp, const std::vector<EntityObservation>& found) {
    cache_.writer_->put(kDetectionRecord);
    cache_.writer_->put(stamp.ns);
    cache_.writer_->put(static_cast<std::uint64_t>(found.size()));
    for (const EntityObservation& o : found) {
      cache_.writer_->put(o.entity.value);
      cache_.writer_->put(o.semantic_class);
      cache_.writer_->text(o.name);
      cache_.writer_->put(o.stamp.ns);
      cache_.writer_->put(numbers(o.T_base_entity));
      cache_.writer_->put(numbers(o.covariance));
      cache_.writer_->put(o.reprojection_rms_px);
      cache_.writer_->put(o.tag_count);
      cache_.writer_->text(o.sensor_label);
    }
    cache_.writer_->put(static_cast<std::uint64_t>(warnings_.size()));
    for (const auto& [text, count] : warnings_) {
      cache_.writer_->text(text);
      cache_.writer_->put(count);
    }
  }

  std::vector<EntityObservation> replay(Stamp stamp) {
    if (cache_.reader_->get<std::uint8_t>() != kDetectionRecord ||
        cache_.reader_->get<std::int64_t>() != stamp.ns)
      throw DataError(cache_.file_.string() + ": belongs to another recording; delete it");
    std::vector<EntityObservation> found;
    for (auto left = cache_.reader_->get<std::uint64_t>(); left > 0; --left) {
      EntityObservation o;
      o.entity.value = cache_.reader_->get<std::int64_t>();
      o.semantic_class = cache_.reader_->get<SemanticClass>();
      o.name = cache_.reader_->text();
      o.stamp.ns = cache_.reader_->get<std::int64_t>();
      o.T_base_entity = pose(cache_.reader_->get<PoseNumbers>());
      o.covariance = matrix(cache_.reader_->get<std::array<double, 36>>());
      o.reprojection_rms_px = cache_.reader_->get<double>();
      o.tag_count = cache_.reader_->get<int>();
      o.sensor_label = cache_.reader_->text();
      found.push_back(std::move(o));
    }
    for (auto left = cache_.reader_->get<std::uint64_t>(); left > 0; --left) {
      const std::string text = cache_.reader_->text();
      warnings_[text] = cache_.reader_->get<std::uint64_t>();
    }
    return found;
  }

  FrontEndCache& cache_;
  std::unique_ptr<EntityDetector> inner_;
};

FrontEndCache::FrontEndCache(fs::path file, const std::string& identity)
    : file_(std::move(file)),
      identity_(identity),
      // Its own name for each process: several may record at the same time.
      temporary_(file_.string() + "." + std::to_string(::getpid()) + ".part") {
  if (opens(identity)) return;
  std::error_code failure;
  if (file_.has_parent_path()) fs::create_directories(file_.parent_path(), failure);
  out_.open(temporary_, std::ios::binary);
  if (!out_) throw DataError(temporary_.string() + ": cannot be written");
  writer_ = std::make_unique<RecordWriter>(out_, temporary_);
  writer_->text(kFormat);
  writer_->text(identity);
}

bool FrontEndCache::opens(const std::string& identity) {
  in_.open(file_, std::ios::binary);
  if (!in_.is_open()) return false;
  reader_ = std::make_unique<RecordReader>(in_, file_);
  try {
    if (reader_->text() == kFormat && reader_->text() == identity) return true;
  } catch (const DataError&) {
    // Not a cache, or an older one: recorded anew.
  }
  reader_.reset();
  in_.close();
  return false;
}

FrontEndCache::~FrontEndCache() {
  if (!out_.is_open()) return;
  out_.close();
  std::error_code ignored;
  fs::remove(temporary_, ignored);
}

std::unique_ptr<ScanOdometry> FrontEndCache::wrap(std::unique_ptr<ScanOdometry> odometry) {
  return std::make_unique<Odometry>(*this, std::move(odometry));
}

std::unique_ptr<PlaneExtractor> FrontEndCache::wrap(std::unique_ptr<PlaneExtractor> extractor) {
  return std::make_unique<PlaneCache>(file_.string() + ".planes", identity_, std::move(extractor));
}

std::unique_ptr<EntityDetector> FrontEndCache::wrap(std::unique_ptr<EntityDetector> detector) {
  return std::make_unique<Detector>(*this, std::move(detector));
}

void FrontEndCache::finish() {
  if (!out_.is_open()) return;
  writer_->put(kEnd);
  out_.close();
  std::error_code failure;
  if (out_) fs::rename(temporary_, file_, failure);
  if (!out_ || failure) throw DataError(file_.string() + ": cannot be written");
}

std::string frontEndIdentity(const DynemoParams& params, const fs::path& rawlog,
                             const std::optional<fs::path>& entities) {
  std::ostringstream text;
  const auto describe = [&](const fs::path& file) {
    std::error_code ignored;
    text << file.filename().string() << " " << fs::file_size(file, ignored) << " "
         << fs::last_write_time(file, ignored).time_since_epoch().count() << "\n";
  };
  describe(rawlog);
  if (entities) describe(*entities);
  // The noise belongs to the map: setups differ in it.
  RobotOdometryParams odometry = params.odometry;
  odometry.noise = {};
  text << toYaml(params.sensors, false) << toYaml(odometry, false)
       << toYaml(params.perception, false);
  return text.str();
}

}  // namespace dynemo
