#include "dynemo/core/output_file.h"

#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <set>
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

void prepareFolderOf(const fs::path& file) {
  // An ending slash names the folder itself.
  const fs::path folder =
      fs::absolute(file.has_filename() ? file : file.parent_path()).parent_path();
  std::error_code failure;
  fs::create_directories(folder, failure);
  if (!failure && ::access(folder.c_str(), W_OK | X_OK) != 0)
    failure = std::error_code(errno, std::generic_category());
  if (failure) throw DataError(file.string() + ": cannot be written: " + failure.message());
}

namespace {

/// Devices and pipes stay what they are.
void writeInto(const fs::path& file, const std::string& content) {
  std::ofstream out(file, std::ios::binary);
  out.write(content.data(), static_cast<std::streamsize>(content.size()));
  out.close();
  if (!out) throw DataError(file.string() + ": cannot be written");
}

}  // namespace

void writeFileAtomically(const fs::path& name, const std::string& content) {
  std::error_code ignored;
  // A link stays one, too: what it leads to is replaced.
  const fs::path file = fs::is_symlink(name, ignored) ? fs::weakly_canonical(name, ignored) : name;
  const fs::file_status there = fs::status(file, ignored);
  if (fs::exists(there) && !fs::is_regular_file(there) && !fs::is_directory(there))
    return writeInto(file, content);
  const fs::path temporary = file.string() + ".part";
  {
    std::ofstream out(temporary, std::ios::binary | std::ios::trunc);
    out.write(content.data(), static_cast<std::streamsize>(content.size()));
    out.close();
    if (!out) {
      fs::remove(temporary, ignored);
      const bool nowhere = file.has_parent_path() && !fs::exists(file.parent_path(), ignored);
      throw DataError(file.string() + ": cannot be written (" +
                      (nowhere ? "its folder does not exist)" : "disk full, or no permission?)"));
    }
  }
  std::error_code failure;
  fs::rename(temporary, file, failure);
  if (failure) {
    fs::remove(temporary, ignored);
    throw DataError(file.string() + ": cannot be replaced: " + failure.message());
  }
}

namespace {

/// Nobody's other files are lost with a folder that is replaced.
void requireReplaceable(const fs::path& folder, const std::map<std::string, std::string>& files) {
  if (!fs::exists(folder)) return;
  if (!fs::is_directory(folder))
    throw DataError(folder.string() + ": cannot be replaced: is not a folder");
  std::set<fs::path> extensions;
  for (const auto& [name, content] : files) extensions.insert(fs::path(name).extension());
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_directory() || !extensions.contains(entry.path().extension()))
      throw DataError(folder.string() + ": is not replaced, because it also holds " +
                      entry.path().filename().string());
}

}  // namespace

void writeFolderAtomically(const fs::path& folder,
                           const std::map<std::string, std::string>& files) {
  requireReplaceable(folder, files);
  const fs::path temporary = folder.string() + ".part";
  std::error_code failure, ignored;
  fs::remove_all(temporary, ignored);
  fs::create_directory(temporary, failure);
  if (failure) throw DataError(folder.string() + ": cannot be created: " + failure.message());
  try {
    for (const auto& [name, content] : files) writeFileAtomically(temporary / name, content);
  } catch (const DataError& e) {
    fs::remove_all(temporary, ignored);
    throw DataError(folder.string() + ": " + e.what());
  }
  fs::remove_all(folder, failure);
  if (!failure) fs::rename(temporary, folder, failure);
  if (failure) {
    fs::remove_all(temporary, ignored);
    throw DataError(folder.string() + ": cannot be replaced: " + failure.message());
  }
}

std::string exactNumber(double value) {
  char buffer[64];
  const auto result = std::to_chars(buffer, buffer + sizeof(buffer), value);
  return {buffer, result.ptr};
}

}  // namespace dynemo
