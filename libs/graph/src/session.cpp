#include "dynemo/graph/session.h"

#include <mrpt/io/CMemoryStream.h>
#include <mrpt/serialization/CArchive.h>

#include <cstdio>
#include <fstream>
#include <functional>
#include <sstream>

#include "archive.h"
#include "dynemo/core/mrpt_conversions.h"
#include "dynemo/core/output_file.h"
#include "dynemo/graph/types.h"

namespace dynemo {

namespace fs = std::filesystem;
using mrpt::serialization::CArchive;

namespace {

constexpr std::uint32_t kMaxPoints = 50'000'000;
constexpr const char* kScanHeader = "dynemo scan 1";
constexpr const char* kSessionHeader = "dynemo session 1";
constexpr const char* kPosesHeader = "dynemo poses 1";
constexpr const char* kPosesEnd = "end";
constexpr std::uint32_t kMaxPoses = 1'000'000'000;

std::string toBytes(const std::function<void(CArchive&)>& write) {
  mrpt::io::CMemoryStream memory;
  auto archive = mrpt::serialization::archiveFrom(memory);
  write(archive);
  return {static_cast<const char*>(memory.getRawBufferData()),
          static_cast<std::size_t>(memory.getTotalBytesCount())};
}

/// A text that tells what a file is or where it ends, its length checked before memory is asked
/// for.
void expectText(CArchive& in, const char* expected) {
  std::string header;
  get(in, header);
  if (header != expected) throw DataError(std::string("'") + expected + "' is missing");
}

/// Reads a whole file through an archive; every failure names the file, and nothing may be left
/// over.
void fromFile(const fs::path& file, const std::function<void(CArchive&)>& read) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw DataError(file.string() + ": is missing or cannot be read");
  std::ostringstream bytes;
  bytes << in.rdbuf();
  const std::string data = bytes.str();
  mrpt::io::CMemoryStream memory(data.data(), data.size());
  auto archive = mrpt::serialization::archiveFrom(memory);
  try {
    read(archive);
  } catch (const std::exception& e) {
    throw DataError(file.string() + ": is damaged: " + mrptReason(e));
  }
  if (memory.getPosition() != data.size())
    throw DataError(file.string() + ": is damaged: bytes after the end");
}

template <class T>
void putArray(CArchive& out, const std::vector<T>& values) {
  out.WriteAs<std::uint32_t>(values.size());
  if (!values.empty()) out.WriteBuffer(values.data(), values.size() * sizeof(T));
}

template <class T>
void getArray(CArchive& in, std::vector<T>& values, std::uint32_t max) {
  const std::uint32_t n = getLength(in, max);
  values.clear();
  // In pieces, so that a damaged length runs into the end of the file before it runs out of memory.
  constexpr std::uint32_t kPiece = 65536;
  for (std::uint32_t done = 0; done < n;) {
    const std::uint32_t piece = std::min(kPiece, n - done);
    values.resize(done + piece);
    if (in.ReadBuffer(values.data() + done, piece * sizeof(T)) != piece * sizeof(T))
      throw DataError("too short");
    done += piece;
  }
}

void putScan(CArchive& out, const Scan& scan) {
  out << std::string(kScanHeader) << scan.stamp.ns;
  put(out, scan.T_base_lidar);
  putArray(out, scan.cloud.points);
  putArray(out, scan.cloud.time_offset_s);
  putArray(out, scan.cloud.row);
  putArray(out, scan.cloud.column);
  out << scan.cloud.rows << scan.cloud.columns;
}

/// What every other part of the program takes for granted of a cloud.
void requireConsistent(const PointCloud& cloud) {
  const auto perPoint = [&](std::size_t size) { return size == 0 || size == cloud.size(); };
  if (!perPoint(cloud.time_offset_s.size()) || !perPoint(cloud.row.size()) ||
      cloud.column.size() != cloud.row.size()) {
    throw DataError("not one attribute per point");
  }
  for (const auto& point : cloud.points) {
    if (!point.allFinite()) throw DataError("a stored point is not finite");
  }
  for (std::size_t i = 0; i < cloud.row.size(); ++i) {
    if (cloud.row[i] >= cloud.rows || cloud.column[i] >= cloud.columns) {
      throw DataError("a stored point lies outside its grid");
    }
  }
}

Scan getScan(CArchive& in) {
  Scan scan;
  expectText(in, kScanHeader);
  in >> scan.stamp.ns;
  get(in, scan.T_base_lidar);
  getArray(in, scan.cloud.points, kMaxPoints);
  const auto n = static_cast<std::uint32_t>(scan.cloud.size());
  getArray(in, scan.cloud.time_offset_s, n);
  getArray(in, scan.cloud.row, n);
  getArray(in, scan.cloud.column, n);
  in >> scan.cloud.rows >> scan.cloud.columns;
  requireConsistent(scan.cloud);
  return scan;
}

void putFrames(CArchive& out, const std::vector<FramePose>& frames) {
  out.WriteAs<std::uint32_t>(frames.size());
  for (const FramePose& frame : frames) {
    out << frame.stamp.ns;
    put(out, frame.T_odom_base);
    put(out, frame.T_map_base);
  }
}

std::vector<FramePose> getFrames(CArchive& in) {
  std::vector<FramePose> frames;
  const std::uint32_t n = getLength(in, kMaxPoses);
  for (std::uint32_t i = 0; i < n; ++i) {
    FramePose& frame = frames.emplace_back();
    in >> frame.stamp.ns;
    get(in, frame.T_odom_base);
    get(in, frame.T_map_base);
  }
  return frames;
}

template <class Matrix>
void putCovariances(CArchive& out, const std::map<NodeId, Matrix>& covariances) {
  out.WriteAs<std::uint32_t>(covariances.size());
  for (const auto& [node, covariance] : covariances) {
    out << node.value;
    for (int r = 0; r < Matrix::RowsAtCompileTime; ++r)
      for (int c = r; c < Matrix::RowsAtCompileTime; ++c) out << covariance(r, c);
  }
}

template <class Matrix>
std::map<NodeId, Matrix> getCovariances(CArchive& in) {
  std::map<NodeId, Matrix> covariances;
  const std::uint32_t n = getLength(in, kMaxPoses);
  for (std::uint32_t i = 0; i < n; ++i) {
    Matrix& covariance = covariances[NodeId{in.ReadAs<std::uint64_t>()}];
    for (int r = 0; r < Matrix::RowsAtCompileTime; ++r)
      for (int c = r; c < Matrix::RowsAtCompileTime; ++c) {
        getFinite(in, covariance(r, c));
        covariance(c, r) = covariance(r, c);
      }
  }
  return covariances;
}

void putPoses(CArchive& out, const std::vector<Pose3>& poses) {
  out.WriteAs<std::uint32_t>(poses.size());
  for (const Pose3& T : poses) put(out, T);
}

std::vector<Pose3> getPoses(CArchive& in) {
  std::vector<Pose3> poses;
  const std::uint32_t n = getLength(in, kMaxPoses);
  for (std::uint32_t i = 0; i < n; ++i) get(in, poses.emplace_back());
  return poses;
}

fs::path cloudFile(const fs::path& folder, NodeId keyframe) {
  char name[32];
  std::snprintf(name, sizeof(name), "%06llu.bin", static_cast<unsigned long long>(keyframe.value));
  return folder / "clouds" / name;
}

}  // namespace

void saveSession(const Session& session, const fs::path& folder) {
  std::error_code failure;
  fs::create_directories(folder / "clouds", failure);
  if (failure) throw DataError(folder.string() + ": cannot be created: " + failure.message());
  std::vector<std::uint64_t> with_cloud;
  for (const auto& keyframe : session.graph.keyframes()) {
    if (!keyframe->scan) continue;
    with_cloud.push_back(keyframe->id.value);
    writeFileAtomically(cloudFile(folder, keyframe->id),
                        toBytes([&](CArchive& out) { putScan(out, *keyframe->scan); }));
  }
  writeFileAtomically(folder / "config.yaml", session.config_yaml);
  writeFileAtomically(folder / "poses.bin", toBytes([&](CArchive& out) {
                        out << std::string(kPosesHeader);
                        putFrames(out, session.frames);
                        putCovariances(out, session.entity_covariances);
                        putCovariances(out, session.plane_covariances);
                        putPoses(out, session.keyframes_without_closures);
                        out << std::string(kPosesEnd);
                      }));
  // Last, so that a graph on disk always has its clouds.
  writeFileAtomically(folder / "graph.bin", toBytes([&](CArchive& out) {
                        out << std::string(kSessionHeader) << session.graph;
                        putArray(out, with_cloud);
                      }));
}

Session loadSession(const fs::path& folder) {
  registerGraphClasses();
  Session session;
  std::vector<std::uint64_t> with_cloud;
  fromFile(folder / "graph.bin", [&](CArchive& in) {
    expectText(in, kSessionHeader);
    in >> session.graph;
    getArray(in, with_cloud, 1'000'000'000);
  });
  for (const std::uint64_t id : with_cloud) {
    const fs::path file = cloudFile(folder, {id});
    fromFile(file, [&](CArchive& in) {
      session.graph.setScan({id}, std::make_shared<const Scan>(getScan(in)));
    });
  }
  if (fs::exists(folder / "poses.bin")) {
    fromFile(folder / "poses.bin", [&](CArchive& in) {
      expectText(in, kPosesHeader);
      session.frames = getFrames(in);
      session.entity_covariances = getCovariances<Matrix6>(in);
      session.plane_covariances = getCovariances<Matrix3>(in);
      session.keyframes_without_closures = getPoses(in);
      expectText(in, kPosesEnd);
    });
  }
  std::ifstream config(folder / "config.yaml", std::ios::binary);
  if (!config)
    throw DataError((folder / "config.yaml").string() + ": is missing or cannot be read");
  std::ostringstream text;
  text << config.rdbuf();
  session.config_yaml = text.str();
  return session;
}

Session loadRunSession(const fs::path& folder) {
  const auto holdsGraph = [](const fs::path& f) { return fs::exists(f / "graph.bin"); };
  const fs::path inside = folder / "session";
  if (!fs::exists(folder)) throw DataError(folder.string() + ": no such folder");
  if (!fs::is_directory(folder)) throw DataError(folder.string() + ": is not a folder of a run");
  if (!holdsGraph(inside) && !holdsGraph(folder)) {
    throw DataError(folder.string() +
                    ": holds no session/graph.bin; dynemo-slam writes it when `session` is among "
                    "its outputs");
  }
  Session session = loadSession(holdsGraph(inside) ? inside : folder);
  if (session.frames.empty()) {
    for (const auto& keyframe : session.graph.keyframes()) {
      session.frames.push_back({keyframe->stamp, keyframe->T_odom_base, keyframe->T_map_base()});
    }
  }
  return session;
}

}  // namespace dynemo
