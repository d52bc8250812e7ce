// Runs LiDAR odometry over a rawlog and writes the trajectory at the scans' stamps:
//   run_odometry LOG.rawlog OUT.tum [section.key=value ...]
// Constant velocity predicts unless the last argument is "odometry".
#include <cstdio>
#include <cstring>
#include <ctime>
#include <fstream>
#include <iostream>

#include "dynemo/core/config.h"
#include "dynemo/core/output_file.h"
#include "dynemo/ingest/rawlog_source.h"
#include "dynemo/odometry/odometry_params.h"
#include "dynemo/odometry/scan_odometry.h"

namespace dynemo {
namespace {

double cpuSeconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

std::string tumLine(const OdometryEstimate& e) {
  const Eigen::Quaterniond q = e.T_odom_base.quaternion();
  std::string line = e.stamp.text();
  for (const double v : {e.T_odom_base.t.x(), e.T_odom_base.t.y(), e.T_odom_base.t.z(), q.x(),
                         q.y(), q.z(), q.w()}) {
    line += " " + exactNumber(v);
  }
  return line;
}

int run(int argc, char** argv) {
  const bool with_log = std::strcmp(argv[argc - 1], "odometry") == 0;
  ConfigLoader loader;
  for (int i = 3; i < argc - (with_log ? 1 : 0); ++i) loader.addOverride(argv[i]);
  OdometryParams params;
  load(loader, params);
  const auto odometry = scanOdometries().make(params.method, params);
  const auto source = makeRawlogSource(IngestParams(), argv[1]);
  AppendFile out(argv[2]);
  int scans = 0, refused = 0;
  double cpu_s = 0.0, worst_s = 0.0;
  while (const auto frame = source->next()) {
    if (!frame->scan) continue;
    const double before_s = cpuSeconds();
    const auto estimate = odometry->update(*frame->scan, with_log ? frame->odometry : std::nullopt);
    const double spent_s = cpuSeconds() - before_s;
    cpu_s += spent_s;
    worst_s = std::max(worst_s, spent_s);
    ++scans;
    if (estimate) {
      out.line(tumLine(*estimate));
    } else {
      ++refused;
    }
  }
  std::printf("%d scans, %d refused, CPU ms per scan: mean %.2f worst %.2f\n", scans, refused,
              1e3 * cpu_s / std::max(1, scans), 1e3 * worst_s);
  return 0;
}

}  // namespace
}  // namespace dynemo

int main(int argc, char** argv) {
  if (argc < 3) {
    std::cerr << "usage: run_odometry LOG.rawlog OUT.tum [section.key=value ...] [odometry]\n";
    return 2;
  }
  try {
    return dynemo::run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    return 3;
  }
}
