#include "gz_stream.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include "dynemo/core/error.h"

namespace dynemo {
namespace {

constexpr std::size_t kBufferBytes = 1 << 18;
constexpr std::size_t kLargestInflate = 1 << 30;
/// The longest header of an object: length, class name, version.
constexpr std::size_t kHeadBytes = 130;
/// zlib's notation for "gzip, with the largest window".
constexpr int kGzipWindow = 16 + MAX_WBITS;
constexpr unsigned char kGzipMagic[] = {0x1F, 0x8B};

std::FILE* openChecked(const std::filesystem::path& file) {
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status)) throw DataError(file.string() + ": no such file");
  if (std::filesystem::is_directory(status))
    throw DataError(file.string() + ": is a folder, not a rawlog");
  if (!std::filesystem::is_regular_file(status))
    throw DataError(file.string() + ": is not a regular file");
  if (std::filesystem::file_size(file, error) == 0) throw DataError(file.string() + ": is empty");
  std::FILE* handle = std::fopen(file.c_str(), "rbe");
  if (handle == nullptr) throw DataError(file.string() + ": cannot be opened for reading");
  return handle;
}

}  // namespace

GzStream::GzStream(const std::filesystem::path& file)
    : file_(openChecked(file), &std::fclose),
      size_(std::filesystem::file_size(file)),
      input_(kBufferBytes) {
  refill();
  compressed_ = zlib_.avail_in >= sizeof(kGzipMagic) &&
                std::memcmp(zlib_.next_in, kGzipMagic, sizeof(kGzipMagic)) == 0;
  if (compressed_ && inflateInit2(&zlib_, kGzipWindow) != Z_OK) throw std::bad_alloc();
}

GzStream::~GzStream() {
  if (compressed_) inflateEnd(&zlib_);
}

void GzStream::beginObject() {
  object_bytes_ = 0;
  head_.clear();
  data_.clear();
}

bool GzStream::refill() {
  const std::size_t got = std::fread(input_.data(), 1, input_.size(), file_.get());
  taken_from_file_ += got;
  zlib_.next_in = input_.data();
  zlib_.avail_in = static_cast<unsigned>(got);
  if (got == 0 && std::ferror(file_.get()) != 0) error_ = "the file cannot be read further";
  return got > 0;
}

std::size_t GzStream::readPlain(unsigned char* out, std::size_t count) {
  std::size_t done = 0;
  while (done < count && (zlib_.avail_in > 0 || refill())) {
    const std::size_t step = std::min<std::size_t>(count - done, zlib_.avail_in);
    std::memcpy(out + done, zlib_.next_in, step);
    zlib_.next_in += step;
    zlib_.avail_in -= static_cast<unsigned>(step);
    done += step;
  }
  return done;
}

/// A compressed file may consist of several members; anything else after one is ignored, as gzip
/// does.
void GzStream::startNextMember() {
  const bool another = zlib_.avail_in > 0 && zlib_.next_in[0] == kGzipMagic[0];
  if (another)
    inflateReset(&zlib_);
  else
    member_ended_ = true;
}

std::size_t GzStream::readCompressed(unsigned char* out, std::size_t count) {
  zlib_.next_out = out;
  std::size_t done = 0;
  while (done < count && !member_ended_ && error_.empty()) {
    if (zlib_.avail_in == 0 && !refill()) {
      if (error_.empty()) error_ = "the compressed data is incomplete";
      break;
    }
    const auto wanted = static_cast<unsigned>(std::min(count - done, kLargestInflate));
    zlib_.avail_out = wanted;
    const int result = inflate(&zlib_, Z_NO_FLUSH);
    done += wanted - zlib_.avail_out;
    if (result == Z_STREAM_END) {
      if (zlib_.avail_in == 0) refill();
      startNextMember();
    } else if (result != Z_OK && result != Z_BUF_ERROR) {
      error_ = std::string("the compressed data is corrupt") +
               (zlib_.msg != nullptr ? std::string(" (") + zlib_.msg + ")" : "");
    }
  }
  return done;
}

size_t GzStream::Read(void* buffer, size_t count) {
  auto* out = static_cast<unsigned char*>(buffer);
  const std::size_t done = compressed_ ? readCompressed(out, count) : readPlain(out, count);
  if (done < count && object_bytes_ + done > 0)
    throw std::runtime_error("the file ends inside an object");
  object_bytes_ += done;
  if (head_.size() < kHeadBytes)
    head_.append(static_cast<const char*>(buffer), std::min(done, kHeadBytes - head_.size()));
  if (keep_data_) data_.append(static_cast<const char*>(buffer), done);
  return done;
}

size_t GzStream::Write(const void*, size_t) { throw std::logic_error("a rawlog is only read"); }

uint64_t GzStream::Seek(int64_t, TSeekOrigin) {
  throw std::logic_error("a rawlog is read in sequence");
}

uint64_t GzStream::getPosition() const { return taken_from_file_ - zlib_.avail_in; }

}  // namespace dynemo
