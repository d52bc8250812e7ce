// How the fields of nodes and edges are written to an MRPT archive: fixed-width, exact doubles.
#pragma once

#include <mrpt/serialization/CArchive.h>

#include <cstdint>
#include <string>

#include "dynemo/core/error.h"
#include "dynemo/core/point_cloud.h"
#include "dynemo/core/se3.h"

namespace dynemo {

inline void put(mrpt::serialization::CArchive& out, const Pose3& T) {
  for (int i = 0; i < 3; ++i) out << T.t[i];
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) out << T.R(r, c);
}

inline void get(mrpt::serialization::CArchive& in, Pose3& T) {
  for (int i = 0; i < 3; ++i) in >> T.t[i];
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) in >> T.R(r, c);
  if (!T.isFinite()) throw DataError("a stored pose is not finite");
}

/// Reads a length and refuses absurd ones, so that a corrupt file cannot ask for gigabytes.
inline std::uint32_t getLength(mrpt::serialization::CArchive& in, std::uint32_t max) {
  const auto n = in.ReadAs<std::uint32_t>();
  if (n > max) throw DataError("a stored length is not plausible: " + std::to_string(n));
  return n;
}

inline void put(mrpt::serialization::CArchive& out, const PointIndices& indices) {
  out.WriteAs<std::uint32_t>(indices.size());
  for (const auto i : indices) out << i;
}

inline void get(mrpt::serialization::CArchive& in, PointIndices& indices) {
  indices.resize(getLength(in, 100'000'000));
  for (auto& i : indices) in >> i;
}

}  // namespace dynemo
