// Text output that is either complete or absent, and that notices a full disk.
#pragma once

#include <filesystem>
#include <fstream>
#include <map>
#include <string>

namespace dynemo {

/// A file that grows while the run goes on; each line is flushed, so an interrupted run leaves what
/// it had.
class AppendFile {
 public:
  AppendFile() = default;
  /// Creates or truncates the file. Throws DataError when it cannot be opened.
  explicit AppendFile(const std::filesystem::path& file);
  /// Throws DataError when the line cannot be written (e.g. the disk is full).
  void line(const std::string& text);

 private:
  std::filesystem::path file_;
  std::ofstream out_;
};

/// Creates the folder that the file shall be in, for programs to call before they work out what to
/// write. Throws DataError when that fails, or when no file can be made in it.
void prepareFolderOf(const std::filesystem::path& file);

/// Replaces `file` by `content` in one step (a temporary file beside it, renamed). Throws
/// DataError, leaving an earlier version in place, when it cannot be written. Where `file` is a
/// link, what it leads to is replaced; a device or a pipe is written to.
void writeFileAtomically(const std::filesystem::path& file, const std::string& content);

/// Replaces `folder` by one that holds exactly these files (content by name): complete or absent as
/// above, but an earlier folder is gone for a moment. Throws DataError when it cannot be written,
/// and when `folder` is no folder, or also holds folders or files of other extensions.
void writeFolderAtomically(const std::filesystem::path& folder,
                           const std::map<std::string, std::string>& files);

/// Shortest decimal text that reads back as the same double.
std::string exactNumber(double value);

}  // namespace dynemo
