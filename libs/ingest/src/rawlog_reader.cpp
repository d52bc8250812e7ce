#include "dynemo/ingest/rawlog_reader.h"

#include <mrpt/maps/registerAllClasses.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CObservation.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/obs/registerAllClasses.h>
#include <mrpt/serialization/CArchive.h>
#include <mrpt/serialization/archiveFrom_std_streams.h>

#include <algorithm>
#include <cctype>
#include <new>

#include "dynemo/core/error.h"
#include "dynemo/core/mrpt_conversions.h"
#include "gz_stream.h"
#include "memory_limit.h"

namespace dynemo {
namespace {

using mrpt::serialization::CSerializable;

RawlogEntry classify(CSerializable::Ptr object) {
  RawlogEntry entry;
  entry.object = std::move(object);
  if (!entry.object) return entry;
  entry.class_name = shortClassName(*entry.object);
  using Kind = RawlogEntry::Kind;
  if (IS_DERIVED(*entry.object, mrpt::obs::CObservation))
    entry.kind = Kind::kObservation;
  else if (IS_CLASS(*entry.object, mrpt::obs::CSensoryFrame))
    entry.kind = Kind::kSensoryFrame;
  else if (IS_CLASS(*entry.object, mrpt::obs::CActionCollection))
    entry.kind = Kind::kActions;
  else
    entry.kind = Kind::kOther;
  return entry;
}

/// The class name in the header of a serialised object (its length with the top bit set, then the
/// name); empty when the bytes are no header.
std::string classNameInHeader(const std::string& head) {
  if (head.empty() || (static_cast<unsigned char>(head[0]) & 0x80) == 0) return {};
  const std::size_t length = static_cast<unsigned char>(head[0]) & 0x7F;
  if (head.size() < 1 + length) return {};
  const std::string name = head.substr(1, length);
  const auto printable = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == ':' || c == '<' ||
           c == '>';
  };
  return std::all_of(name.begin(), name.end(), printable) ? name : std::string();
}

/// What a file is that does not begin with an object, as far as its first bytes tell.
std::string guessedKind(const std::string& head) {
  using namespace std::string_literals;
  const std::pair<std::string, const char*> kKinds[] = {
      {"#ROSBAG"s, "a ROS 1 bag; `dynemo-prep import` makes a rawlog of it"},
      {"SQLite format 3"s, "an SQLite file, as of ROS 2 bags"},
      {"\x89MCAP"s, "an MCAP file, as of ROS 2 bags"},
      {"\x89PNG"s, "a PNG image"},
      {"\xFF\xD8\xFF"s, "a JPEG image"},
      {"PK\x03\x04"s, "a ZIP archive"},
      {"\x1F\x8B"s, "compressed twice"}};
  for (const auto& [begin, kind] : kKinds)
    if (head.starts_with(begin)) return std::string("it is ") + kind;
  const auto text = [](char c) {
    return std::isprint(static_cast<unsigned char>(c)) ||
           std::isspace(static_cast<unsigned char>(c));
  };
  return std::all_of(head.begin(), head.end(), text) ? "it is text"
                                                     : "its first bytes are those of no object";
}

}  // namespace

std::string shortClassName(const mrpt::rtti::CObject& object) {
  const std::string name = object.GetRuntimeClass()->className;
  const auto colon = name.rfind(':');
  return colon == std::string::npos ? name : name.substr(colon + 1);
}

std::optional<Stamp> validStamp(mrpt::Clock::time_point time) {
  static const std::int64_t first = toMrpt(Stamp{0}).time_since_epoch().count();
  constexpr std::int64_t kTicks = 130LL * 366 * 86400 * 10'000'000;
  const std::int64_t ticks = time.time_since_epoch().count();
  if (ticks < first || ticks > first + kTicks) return std::nullopt;
  return fromMrpt(time);
}

void registerRawlogClasses() {
  // The calls also keep the linker from dropping the libraries, which no other symbol may need.
  mrpt::obs::registerAllClasses_mrpt_obs();
  mrpt::maps::registerAllClasses_mrpt_maps();
}

struct RawlogReader::Impl {
  Impl(const std::filesystem::path& file, std::size_t max_object_bytes)
      : file_name(file),
        max_bytes(max_object_bytes),
        stream(file),
        archive(mrpt::serialization::archiveUniquePtrFrom<mrpt::io::CStream>(stream)) {}

  std::string where() const {
    return "after " + std::to_string(objects) + " objects, near byte " +
           std::to_string(stream.getPosition()) + " of " +
           std::to_string(stream.getTotalBytesCount());
  }
  void stopDamaged(const std::string& why) {
    damage = why + ", " + where();
    ended = true;
  }
  void explainFailure();
  [[noreturn]] void refuseForeignFile() const;

  std::filesystem::path file_name;
  std::size_t max_bytes;
  GzStream stream;
  std::unique_ptr<mrpt::serialization::CArchive> archive;
  std::uint64_t objects = 0;
  std::string damage;
  bool ended = false;
};

void RawlogReader::Impl::explainFailure() {
  const std::string name = classNameInHeader(stream.objectHead());
  const std::string& error = stream.compressionError();
  if (!error.empty())
    stopDamaged(error);
  else if (stream.objectBytes() == 0)
    ended = true;
  else if (!name.empty() && mrpt::rtti::findRegisteredClass(name) == nullptr)
    stopDamaged("object of unknown class '" + name + "', which cannot be skipped");
  else if (name.empty() && objects == 0)
    refuseForeignFile();
  else
    stopDamaged(name.empty() ? "bytes that are no object"
                             : "object of class " + name +
                                   " that cannot be read (truncated, corrupt, of a newer version "
                                   "or with unknown content)");
}

void RawlogReader::Impl::refuseForeignFile() const {
  GzStream again(file_name);
  std::string head;
  try {
    for (char byte = 0; head.size() < 64 && again.Read(&byte, 1) == 1;) head += byte;
  } catch (const std::exception&) {
    // Its compression is damaged there.
  }
  throw DataError(file_name.string() + ": is no MRPT rawlog: " + guessedKind(head));
}

RawlogReader::RawlogReader(const std::filesystem::path& file, std::size_t max_object_bytes) {
  registerRawlogClasses();
  impl_ = std::make_unique<Impl>(file, max_object_bytes);
}
RawlogReader::~RawlogReader() = default;
RawlogReader::RawlogReader(RawlogReader&&) noexcept = default;

std::optional<RawlogEntry> RawlogReader::next() {
  if (impl_->ended) return std::nullopt;
  impl_->stream.beginObject();
  try {
    const MemoryLimit limit(impl_->max_bytes);
    auto object = impl_->archive->ReadObject();
    ++impl_->objects;
    RawlogEntry entry = classify(std::move(object));
    entry.bytes = std::move(impl_->stream.objectData());
    return entry;
  } catch (const std::bad_alloc&) {
    impl_->stopDamaged("an object asks for more memory than allowed (corrupt length?)");
  } catch (const std::exception&) {
    // MRPT reports every failure inside an object as an end of file; the stream knows better.
    impl_->explainFailure();
  }
  return std::nullopt;
}

void RawlogReader::keepBytes(bool keep) { impl_->stream.keepObjectData(keep); }
bool RawlogReader::compressed() const { return impl_->stream.compressed(); }
const std::string& RawlogReader::damage() const { return impl_->damage; }
std::uint64_t RawlogReader::objectsRead() const { return impl_->objects; }

double RawlogReader::fractionRead() const {
  const double size = static_cast<double>(impl_->stream.getTotalBytesCount());
  return impl_->ended ? 1.0 : static_cast<double>(impl_->stream.getPosition()) / size;
}

}  // namespace dynemo
