#include "dynemo/exporters/exporter.h"

#include <algorithm>
#include <cctype>

#include "dynemo/core/error.h"

namespace dynemo {
namespace {

/// Of files that no exporter writes, but that one may hope for.
const std::vector<std::string> kOfOtherPrograms = {".jpg", ".jpeg", ".svg", ".pdf",
                                                   ".obj", ".stl",  ".las", ".rawlog"};

bool contains(const std::vector<std::string>& extensions, const std::string& extension) {
  const auto lower = [](std::string text) {
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
  };
  return std::any_of(extensions.begin(), extensions.end(),
                     [&](const std::string& any) { return lower(any) == lower(extension); });
}

/// The formats whose files end so.
std::string formatsOf(const std::string& extension) {
  std::string formats;
  for (const std::string& name : exporters().names()) {
    if (contains(exporters().make(name, ExportParams())->extensions(), extension))
      formats += (formats.empty() ? "" : ", ") + name;
  }
  return formats;
}

}  // namespace

std::vector<std::string> Exporter::extensions() const {
  const std::string extension = std::filesystem::path(fileName()).extension().string();
  if (extension.empty()) return {};
  return {extension};
}

void checkFileName(const std::string& format, const std::filesystem::path& file) {
  const std::string extension = file.extension().string();
  const auto own = exporters().make(format, ExportParams())->extensions();
  if (extension.empty() || contains(own, extension)) return;
  const std::string others = formatsOf(extension);
  if (others.empty() && !contains(kOfOtherPrograms, extension)) return;
  std::string endings;
  for (const std::string& any : own) endings += (endings.empty() ? "" : " or ") + any;
  throw ConfigError(file.string() + ": format " + format +
                    (own.empty() ? " writes a folder" : " writes files that end in " + endings) +
                    (others.empty() ? "" : "; " + extension + " is written by: " + others));
}

}  // namespace dynemo
