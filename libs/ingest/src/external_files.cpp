#include "dynemo/ingest/external_files.h"

namespace dynemo {
namespace fs = std::filesystem;

ExternalFiles::ExternalFiles(const fs::path& rawlog) {
  const fs::path parent = fs::absolute(rawlog).parent_path();
  folder_ = parent / "Images";
  for (const char* suffix : {"_Images", "_images", "_IMAGES"}) {
    const fs::path candidate = parent / (rawlog.stem().string() + suffix);
    std::error_code error;
    if (!fs::is_directory(candidate, error)) continue;
    folder_ = candidate;
    return;
  }
}

std::optional<fs::path> ExternalFiles::find(const std::string& stored_name) const {
  if (stored_name.empty() || stored_name.find('\0') != std::string::npos) return std::nullopt;
  // An absolute name replaces the folder.
  const fs::path path = folder_ / stored_name;
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return std::nullopt;
  return path;
}

}  // namespace dynemo
