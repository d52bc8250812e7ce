#include "dynemo/batch/configuration_check.h"

#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <set>
#include <sstream>
#include <system_error>

#include "dynemo/core/child_process.h"
#include "dynemo/core/error.h"

namespace dynemo {

namespace fs = std::filesystem;

namespace {

/// A file for what a program prints, removed at the end.
class ScratchFile {
 public:
  ScratchFile() {
    std::string pattern = (fs::temp_directory_path() / "dynemo_batch_XXXXXX").string();
    const int file = ::mkstemp(pattern.data());
    if (file < 0) throw DataError(pattern + ": cannot be created");
    ::close(file);
    path_ = pattern;
  }
  ~ScratchFile() {
    std::error_code ignored;
    fs::remove(path_, ignored);
  }
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;

  const fs::path& path() const { return path_; }
  std::string text() const {
    std::ostringstream all;
    all << std::ifstream(path_).rdbuf();
    std::string text = all.str();
    while (!text.empty() && text.back() == '\n') text.pop_back();
    return text;
  }

 private:
  fs::path path_;
};

/// What the program says of itself, without its name in front.
std::string withoutName(const std::string& text, const fs::path& program) {
  const std::string name = program.filename().string() + ": ";
  return text.starts_with(name) ? text.substr(name.size()) : text;
}

void requireConfiguration(const WorkItem& item, const fs::path& program) {
  std::vector<std::string> command = {program.string(), "--dump-config"};
  command.insert(command.end(), item.arguments.begin(), item.arguments.end());
  const ScratchFile said;
  const ChildExit exit = ChildProcess(command, said.path()).wait();
  if (exit.status == 0) return;
  if (exit.status == ChildExit::kCannotStart) throw DataError(said.text());
  const std::string why = withoutName(said.text(), program);
  throw ConfigError("setup " + item.setup + ": " +
                    (why.empty() ? program.string() + " does not print its configuration" : why));
}

}  // namespace

void requireConfigurations(const std::vector<WorkItem>& items, const fs::path& program) {
  // Configurations differ by setup only.
  std::set<std::string> seen;
  for (const WorkItem& item : items)
    if (seen.insert(item.setup).second) requireConfiguration(item, program);
}

}  // namespace dynemo
