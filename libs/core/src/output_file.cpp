#include "dynemo/core/output_file.h"

#include <charconv>
#include <system_error>

#include "dynemo/core/error.h"

namespace dynemo {

namespace fs = std::filesystem;

AppendFile::AppendFile(const fs::path& file)
    : file_(file), out_(file, std::ios::binary | std::ios::trunc) {
  if (!out_) throw DataError(file.string() + ": cannot be created");
}

void AppendFile::line(const std::string& text) {
  out_ << text << '\n' << std::flush;
  if (!out_) {
    out_.clear();
    throw DataError(file_.string() + ": cannot be written (disk full?)");
  }
}

void writeFileAtomically(const fs::path& file, const std::string& content) {
  const fs::path temporary = file.string() + ".part";
  std::error_code ignored;
  {
    std::ofstream out(temporary, std::ios::binary | std::ios::trunc);
    out.write(content.data(), static_cast<std::streamsize>(content.size()));
    out.close();
    if (!out) {
      fs::remove(temporary, ignored);
      throw DataError(file.string() + ": cannot be written (disk full, or no permission?)");
    }
  }
  std::error_code failure;
  fs::rename(temporary, file, failure);
  if (failure) {
    fs::remove(temporary, ignored);
    throw DataError(file.string() + ": cannot be replaced: " + failure.message());
  }
}

std::string exactNumber(double value) {
  char buffer[64];
  const auto result = std::to_chars(buffer, buffer + sizeof(buffer), value);
  return {buffer, result.ptr};
}

}  // namespace dynemo
