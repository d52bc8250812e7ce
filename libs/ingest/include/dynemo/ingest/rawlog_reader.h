// The objects of a rawlog, one after the other, from plain or gzip-compressed files.
#pragma once

#include <mrpt/core/Clock.h>
#include <mrpt/rtti/CObject.h>
#include <mrpt/serialization/CSerializable.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "dynemo/core/time.h"

namespace dynemo {

/// The class of an object without its namespace.
std::string shortClassName(const mrpt::rtti::CObject& object);

/// Stamps are taken between 1970 and 2100; anything else is corrupt, or MRPT's "no time stamp".
std::optional<Stamp> validStamp(mrpt::Clock::time_point time);

/// Registers the observation and map classes with MRPT, so that they can be read; harmless when
/// repeated.
void registerRawlogClasses();

struct RawlogEntry {
  enum class Kind : std::uint8_t { kObservation, kSensoryFrame, kActions, kNull, kOther };
  Kind kind = Kind::kNull;
  std::string class_name;  ///< without namespace; empty for a stored null object
  mrpt::serialization::CSerializable::Ptr object;  ///< null for kNull only
  std::string bytes;                               ///< as stored, when the reader keeps them
};

/// Reads one object at a time; memory does not depend on the length of the file. Not thread-safe,
/// and while next() runs the address space of the process may grow by at most `max_object_bytes`.
class RawlogReader {
 public:
  /// Throws DataError when the file is missing, empty, not a regular file or not readable.
  RawlogReader(const std::filesystem::path& file, std::size_t max_object_bytes);
  ~RawlogReader();
  RawlogReader(RawlogReader&&) noexcept;

  /// Whether entries come with their bytes, so that they can be copied unchanged; off at first.
  void keepBytes(bool keep);
  /// Whether the file is gzip-compressed.
  bool compressed() const;

  /// The next object, or nothing at the end of what can be read. Throws DataError when the file
  /// does not begin with an object: it is no rawlog, and what it seems to be is said.
  std::optional<RawlogEntry> next();

  /// Why and roughly where reading ended before the end of the file; empty when it did not.
  const std::string& damage() const;
  /// Objects read so far, stored null objects included.
  std::uint64_t objectsRead() const;
  /// Fraction of the file's bytes consumed, in [0, 1].
  double fractionRead() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace dynemo
