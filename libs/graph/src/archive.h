// How the fields of nodes and edges are written to an MRPT archive: fixed-width, exact doubles.
#pragma once

#include <mrpt/serialization/CArchive.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include "dynemo/core/error.h"
#include "dynemo/core/point_cloud.h"
#include "dynemo/core/se3.h"

namespace dynemo {

/// Reads a number that must be finite.
inline void getFinite(mrpt::serialization::CArchive& in, double& value) {
  in >> value;
  if (!std::isfinite(value)) throw DataError("a stored number is not finite");
}

/// MRPT reads a bool's byte as it is; any other value than 0 and 1 would be undefined behaviour.
inline bool getBool(mrpt::serialization::CArchive& in) {
  const auto byte = in.ReadAs<std::uint8_t>();
  if (byte > 1) throw DataError("a stored flag is neither true nor false");
  return byte == 1;
}

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

/// Text in MRPT's layout, its length checked before memory is asked for.
inline void get(mrpt::serialization::CArchive& in, std::string& text) {
  text.resize(getLength(in, 65'536));
  if (!text.empty()) in.ReadBuffer(text.data(), text.size());
}

inline void put(mrpt::serialization::CArchive& out, const PointIndices& indices) {
  out.WriteAs<std::uint32_t>(indices.size());
  for (const auto i : indices) out << i;
}

inline void get(mrpt::serialization::CArchive& in, PointIndices& indices) {
  const std::uint32_t n = getLength(in, 100'000'000);
  indices.clear();
  // Grows with what is really there: a corrupt length ends at the end of the data, not in the
  // memory limit.
  indices.reserve(std::min<std::uint32_t>(n, 65'536));
  for (std::uint32_t i = 0; i < n; ++i) indices.push_back(in.ReadAs<std::uint32_t>());
}

}  // namespace dynemo
