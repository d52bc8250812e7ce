#include "gz_stream.h"

#include <algorithm>
#include <stdexcept>

#include "dynemo/core/error.h"

namespace dynemo {
namespace {

constexpr unsigned kBufferBytes = 1 << 18;
constexpr std::size_t kLargestRead = 1 << 30;
/// The longest header of an object: length, class name, version.
constexpr std::size_t kHeadBytes = 130;

gzFile openChecked(const std::filesystem::path& file) {
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status)) throw DataError(file.string() + ": no such file");
  if (std::filesystem::is_directory(status))
    throw DataError(file.string() + ": is a folder, not a rawlog");
  if (!std::filesystem::is_regular_file(status))
    throw DataError(file.string() + ": is not a regular file");
  if (std::filesystem::file_size(file, error) == 0) throw DataError(file.string() + ": is empty");
  const gzFile handle = gzopen(file.c_str(), "rb");
  if (handle == nullptr) throw DataError(file.string() + ": cannot be opened for reading");
  gzbuffer(handle, kBufferBytes);
  return handle;
}

}  // namespace

GzStream::GzStream(const std::filesystem::path& file)
    : file_(openChecked(file), &gzclose_r), size_(std::filesystem::file_size(file)) {}

void GzStream::beginObject() {
  object_bytes_ = 0;
  head_.clear();
}

std::string GzStream::compressionError() const {
  int code = Z_OK;
  const char* text = gzerror(file_.get(), &code);
  return code == Z_OK || code == Z_STREAM_END ? "" : text;
}

size_t GzStream::Read(void* buffer, size_t count) {
  auto* out = static_cast<char*>(buffer);
  std::size_t done = 0;
  while (done < count) {
    const auto wanted = static_cast<unsigned>(std::min(count - done, kLargestRead));
    const int got = gzread(file_.get(), out + done, wanted);
    if (got <= 0) break;
    done += static_cast<std::size_t>(got);
  }
  if (done < count && object_bytes_ + done > 0)
    throw std::runtime_error("the file ends inside an object");
  object_bytes_ += done;
  if (head_.size() < kHeadBytes) head_.append(out, std::min(done, kHeadBytes - head_.size()));
  return done;
}

size_t GzStream::Write(const void*, size_t) { throw std::logic_error("a rawlog is only read"); }

uint64_t GzStream::Seek(int64_t, TSeekOrigin) {
  throw std::logic_error("a rawlog is read in sequence");
}

uint64_t GzStream::getPosition() const {
  const auto offset = gzoffset(file_.get());
  return offset < 0 ? size_ : std::min(size_, static_cast<std::uint64_t>(offset));
}

}  // namespace dynemo
