#pragma once

#include <mrpt/io/CStream.h>
#include <zlib.h>

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace dynemo {

/// Sequential reading of a plain or gzip-compressed file of serialised objects. Unlike
/// CFileGZInputStream it tells the end between two objects from one inside an object and a complete
/// compressed file from a damaged one, and it delivers every byte before the damage.
class GzStream : public mrpt::io::CStream {
 public:
  /// Throws DataError when the file is missing, empty, not a regular file or not readable.
  explicit GzStream(const std::filesystem::path& file);
  ~GzStream() override;
  GzStream(const GzStream&) = delete;
  GzStream& operator=(const GzStream&) = delete;

  /// Marks the beginning of an object.
  void beginObject();
  /// Bytes read of the present object.
  std::uint64_t objectBytes() const { return object_bytes_; }
  /// Whether objectData() is kept.
  void keepObjectData(bool keep) { keep_data_ = keep; }
  /// Every byte read of the present object.
  std::string& objectData() { return data_; }
  bool compressed() const { return compressed_; }
  /// The first bytes read of the present object.
  const std::string& objectHead() const { return head_; }
  /// What is wrong with the compression of the file; empty when nothing is (so far).
  const std::string& compressionError() const { return error_; }

  /// Zero at the end between two objects; throws std::runtime_error on a short read inside one.
  size_t Read(void* buffer, size_t count) override;
  size_t Write(const void* buffer, size_t count) override;
  uint64_t Seek(int64_t offset, TSeekOrigin origin) override;
  /// Size and position in bytes of the file, compressed or not.
  uint64_t getTotalBytesCount() const override { return size_; }
  uint64_t getPosition() const override;

 private:
  bool refill();
  std::size_t readPlain(unsigned char* out, std::size_t count);
  std::size_t readCompressed(unsigned char* out, std::size_t count);
  void startNextMember();

  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
  std::uint64_t size_ = 0;
  std::vector<unsigned char> input_;
  z_stream zlib_{};  ///< next_in and avail_in are the unread part of input_, compressed or not
  bool compressed_ = false;
  bool member_ended_ = false;
  bool keep_data_ = false;
  std::uint64_t taken_from_file_ = 0;
  std::uint64_t object_bytes_ = 0;
  std::string head_, data_, error_;
};

}  // namespace dynemo
