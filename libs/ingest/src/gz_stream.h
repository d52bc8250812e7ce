#pragma once

#include <mrpt/io/CStream.h>
#include <zlib.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

namespace dynemo {

/// Sequential reading of a plain or gzip-compressed file of serialised objects. Unlike
/// CFileGZInputStream it tells the end between two objects from one inside an object, and a
/// complete compressed file from a truncated one.
class GzStream : public mrpt::io::CStream {
 public:
  /// Throws DataError when the file is missing, empty, not a regular file or not readable.
  explicit GzStream(const std::filesystem::path& file);

  /// Marks the beginning of an object.
  void beginObject();
  /// Bytes read of the present object.
  std::uint64_t objectBytes() const { return object_bytes_; }
  /// The first bytes read of the present object.
  const std::string& objectHead() const { return head_; }
  /// What zlib says is wrong with the file; empty when nothing is.
  std::string compressionError() const;

  /// Zero at the end between two objects; throws std::runtime_error on a short read inside one.
  size_t Read(void* buffer, size_t count) override;
  size_t Write(const void* buffer, size_t count) override;
  uint64_t Seek(int64_t offset, TSeekOrigin origin) override;
  /// Size and position in bytes of the file, compressed or not.
  uint64_t getTotalBytesCount() const override { return size_; }
  uint64_t getPosition() const override;

 private:
  std::unique_ptr<gzFile_s, int (*)(gzFile)> file_;
  std::uint64_t size_ = 0;
  std::uint64_t object_bytes_ = 0;
  std::string head_;
};

}  // namespace dynemo
