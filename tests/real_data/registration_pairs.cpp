#include "registration_pairs.h"

#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>
#include <zlib.h>

#include <array>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace dynemo::test {
namespace {

using PclCloud = pcl::PointCloud<pcl::PointXYZ>;

Scan scanOf(const PclCloud& cloud) {
  Scan scan;
  for (const pcl::PointXYZ& p : cloud) scan.cloud.points.emplace_back(p.x, p.y, p.z);
  return scan;
}

Scan readPcd(const std::filesystem::path& file) {
  PclCloud cloud;
  if (pcl::io::loadPCDFile(file.string(), cloud) != 0)
    throw std::runtime_error("cannot read " + file.string());
  return scanOf(cloud);
}

Scan readPly(const std::filesystem::path& file) {
  PclCloud cloud;
  if (pcl::io::loadPLYFile(file.string(), cloud) != 0)
    throw std::runtime_error("cannot read " + file.string());
  return scanOf(cloud);
}

std::string gunzip(const std::filesystem::path& file) {
  const gzFile in = gzopen(file.c_str(), "rb");
  if (in == nullptr) throw std::runtime_error("cannot read " + file.string());
  std::string text;
  std::array<char, 65536> chunk{};
  for (int n = 0; (n = gzread(in, chunk.data(), chunk.size())) > 0;)
    text.append(chunk.data(), static_cast<std::size_t>(n));
  gzclose(in);
  return text;
}

/// "POINTS n float" and then n triples.
Scan readVtk(const std::filesystem::path& file) {
  std::istringstream in(gunzip(file));
  std::string word;
  while (in >> word && word != "POINTS") {
  }
  std::size_t count = 0;
  if (!(in >> count >> word)) throw std::runtime_error("no points in " + file.string());
  Scan scan;
  scan.cloud.points.resize(count);
  for (Eigen::Vector3f& p : scan.cloud.points) in >> p.x() >> p.y() >> p.z();
  if (!in) throw std::runtime_error("points are missing in " + file.string());
  return scan;
}

Pose3 readMatrix(const std::filesystem::path& file) {
  std::ifstream in(file);
  Eigen::Matrix4d T;
  for (int row = 0; row < 4; ++row)
    for (int col = 0; col < 4; ++col) in >> T(row, col);
  if (!in) throw std::runtime_error("no matrix in " + file.string());
  return {nearestRotation(T.topLeftCorner<3, 3>()), T.topRightCorner<3, 1>()};
}

}  // namespace

RegistrationPair readSmallGicpPair(const std::filesystem::path& registration_folder,
                                   Pose3& T_target_source) {
  const auto folder = registration_folder / "small_gicp_pair";
  T_target_source = readMatrix(folder / "T_target_source.txt");
  return {readPly(folder / "target.ply"), readPly(folder / "source.ply")};
}

RegistrationPair readApartmentPair(const std::filesystem::path& registration_folder) {
  const auto folder = registration_folder / "libpointmatcher_apartment";
  return {readVtk(folder / "cloud_0.vtk.gz"), readVtk(folder / "cloud_1.vtk.gz")};
}

RegistrationPair readPclRoomPair(const std::filesystem::path& registration_folder) {
  const auto folder = registration_folder / "pcl_room";
  return {readPcd(folder / "room_scan1.pcd"), readPcd(folder / "room_scan2.pcd")};
}

}  // namespace dynemo::test
