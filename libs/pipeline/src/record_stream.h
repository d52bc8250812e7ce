// Plain values in and out of binary streams, for caches: the layout is the machine's own.
#pragma once

#include <cstdint>
#include <filesystem>
#include <iostream>
#include <string>
#include <type_traits>
#include <vector>

#include "dynemo/core/error.h"

namespace dynemo {

class RecordWriter {
 public:
  /// The stream must outlive the writer; the file is named in errors.
  RecordWriter(std::ostream& out, std::filesystem::path file) : out_(out), file_(std::move(file)) {}

  /// Throws DataError when it cannot be written.
  template <class T>
  void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes(&value, sizeof(T));
  }
  void text(const std::string& text) {
    put(static_cast<std::uint64_t>(text.size()));
    bytes(text.data(), text.size());
  }
  template <class T>
  void list(const std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    put(static_cast<std::uint64_t>(values.size()));
    bytes(values.data(), values.size() * sizeof(T));
  }

 private:
  void bytes(const void* data, std::size_t size) {
    out_.write(static_cast<const char*>(data), static_cast<std::streamsize>(size));
    if (!out_) throw DataError(file_.string() + ": cannot be written");
  }

  std::ostream& out_;
  std::filesystem::path file_;
};

class RecordReader {
 public:
  RecordReader(std::istream& in, std::filesystem::path file) : in_(in), file_(std::move(file)) {}

  /// Throws DataError at the end of the file.
  template <class T>
  T get() {
    static_assert(std::is_trivially_copyable_v<T>);
    T value;
    bytes(&value, sizeof(T));
    return value;
  }
  std::string text() {
    std::string text(length(1), '\0');
    bytes(text.data(), text.size());
    return text;
  }
  template <class T>
  std::vector<T> list() {
    static_assert(std::is_trivially_copyable_v<T>);
    std::vector<T> values(length(sizeof(T)));
    bytes(values.data(), values.size() * sizeof(T));
    return values;
  }

 private:
  /// A damaged length must not ask for all memory.
  std::size_t length(std::size_t size) {
    constexpr std::uint64_t kMost_bytes = 1 << 28;
    const auto count = get<std::uint64_t>();
    if (count > kMost_bytes / size) throw DataError(file_.string() + ": is damaged; delete it");
    return static_cast<std::size_t>(count);
  }
  void bytes(void* data, std::size_t size) {
    in_.read(static_cast<char*>(data), static_cast<std::streamsize>(size));
    if (!in_) throw DataError(file_.string() + ": is shorter than the recording; delete it");
  }

  std::istream& in_;
  std::filesystem::path file_;
};

}  // namespace dynemo
