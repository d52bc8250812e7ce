// Makes a small rawlog out of a large one: drops all but every n-th observation of chosen sensors,
// and all but every n-th point of each point cloud. What is left stays as it was, stamps and poses
// included; images stored outside the rawlog stay outside, so theirs must be copied beside it.
// rawlog-edit cuts by time and by label, but not this way.
#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/maps/CPointsMap.h>
#include <mrpt/maps/registerAllClasses.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/serialization/CArchive.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

struct Options {
  std::string input, output;
  std::vector<std::string> labels;
  std::size_t keep_every = 1, keep_points_every = 1;
};

/// Counts the observations of each thinned sensor.
class Thinning {
 public:
  explicit Thinning(const Options& options) : every_(options.keep_every) {
    for (const std::string& label : options.labels) seen_[label] = 0;
  }
  bool keeps(const mrpt::obs::CObservation& observation) {
    const auto sensor = seen_.find(observation.sensorLabel);
    return sensor == seen_.end() || sensor->second++ % every_ == 0;
  }

 private:
  std::size_t every_;
  std::map<std::string, std::size_t> seen_;
};

void thinPoints(mrpt::maps::CPointsMap& points, std::size_t keep_every) {
  std::vector<bool> doomed(points.size());
  for (std::size_t i = 0; i < doomed.size(); ++i) doomed[i] = i % keep_every != 0;
  points.applyDeletionMask(doomed);
}

/// Null at the end of the file. Throws std::runtime_error when the file is cut short or holds
/// anything else.
mrpt::obs::CObservation::Ptr nextObservation(mrpt::io::CFileGZInputStream& in,
                                             mrpt::serialization::CArchive& source) {
  try {
    auto observation = std::dynamic_pointer_cast<mrpt::obs::CObservation>(source.ReadObject());
    if (!observation) throw std::runtime_error("not a rawlog of observations only");
    return observation;
  } catch (const mrpt::serialization::CExceptionEOF&) {
    if (!in.checkEOF()) throw std::runtime_error("the rawlog is damaged");
    return nullptr;
  }
}

/// Returns the number of observations written. Throws std::runtime_error when a file cannot be
/// opened.
std::size_t thinRawlog(const Options& options) {
  mrpt::io::CFileGZInputStream in(options.input);
  mrpt::io::CFileGZOutputStream out;
  constexpr int kBestCompression = 9;
  if (!out.open(options.output, kBestCompression))
    throw std::runtime_error("cannot write '" + options.output + "'");
  auto source = mrpt::serialization::archiveFrom(in);
  auto sink = mrpt::serialization::archiveFrom(out);
  Thinning thinning(options);
  std::size_t written = 0;
  while (const auto observation = nextObservation(in, source)) {
    if (!thinning.keeps(*observation)) continue;
    auto* scan = dynamic_cast<mrpt::obs::CObservationPointCloud*>(observation.get());
    if (scan != nullptr && scan->pointcloud)
      thinPoints(*scan->pointcloud, options.keep_points_every);
    sink << *observation;
    ++written;
  }
  return written;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Keep every n-th observation of chosen sensors and every n-th point of a rawlog");
  app.add_option("--label", options.labels, "Sensor label to thin; may be repeated");
  app.add_option("--keep-every", options.keep_every, "Keep every n-th observation of those")
      ->check(CLI::PositiveNumber);
  app.add_option("--keep-points-every", options.keep_points_every, "Keep every n-th point")
      ->check(CLI::PositiveNumber);
  app.add_option("input", options.input, "Rawlog to read")->required()->check(CLI::ExistingFile);
  app.add_option("output", options.output, "Rawlog to write")->required();
  CLI11_PARSE(app, argc, argv);
  mrpt::maps::registerAllClasses_mrpt_maps();
  try {
    std::printf("%zu observations\n", thinRawlog(options));
  } catch (const std::exception& e) {
    std::fprintf(stderr, "rawlog-thin: %s\n", e.what());
    return 3;
  }
  return 0;
}
