// Little-endian binary values at the end of a byte string.
#pragma once

#include <bit>
#include <cstring>
#include <string>

namespace dynemo {

static_assert(std::endian::native == std::endian::little,
              "the binary formats are written as the machine stores them");

template <class T>
void append(std::string& bytes, const T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  char buffer[sizeof(T)];
  std::memcpy(buffer, &value, sizeof(T));
  bytes.append(buffer, sizeof(T));
}

}  // namespace dynemo
