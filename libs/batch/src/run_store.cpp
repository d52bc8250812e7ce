#include "dynemo/batch/run_store.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <fstream>
#include <sstream>
#include <system_error>

#include "dynemo/core/error.h"
#include "dynemo/core/output_file.h"

namespace dynemo {

namespace fs = std::filesystem;

namespace {

void makeFolder(const fs::path& folder) {
  std::error_code failure;
  fs::create_directories(folder, failure);
  if (failure) throw DataError(folder.string() + ": cannot be made: " + failure.message());
}

/// The arguments of a run, one a line; also what tells whether a result is that of this item.
std::string commandText(const WorkItem& item) {
  std::string text;
  for (const std::string& argument : item.arguments) text += argument + "\n";
  return text;
}

std::string contentOf(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

constexpr const char* kArgumentsFile = "arguments.txt";

}  // namespace

RunStore::RunStore(const fs::path& work) : work_(fs::absolute(work).lexically_normal()) {
  makeFolder(work_ / ".runs");
}

fs::path RunStore::attempt(const WorkItem& item, const char* what) const {
  return work_ / ".runs" / item.name / what;
}

fs::path RunStore::unfinishedFolder(const WorkItem& item) const { return attempt(item, "run"); }

fs::path RunStore::consoleFile(const WorkItem& item) const { return attempt(item, "console.txt"); }

RunState RunStore::state(const WorkItem& item) const {
  if (fs::exists(folder(item) / kArgumentsFile)) {
    if (contentOf(folder(item) / kArgumentsFile) != commandText(item))
      throw ConfigError(folder(item).string() +
                        ": was made with other arguments (see its arguments.txt); remove it or use "
                        "another work folder");
    return RunState::kDone;
  }
  return fs::exists(attempt(item, "failure.txt")) ? RunState::kFailed : RunState::kMissing;
}

std::string RunStore::failure(const WorkItem& item) const {
  std::string text = contentOf(attempt(item, "failure.txt"));
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

void RunStore::begin(const WorkItem& item) const {
  makeFolder(work_ / ".runs" / item.name);
  std::error_code failure;
  fs::remove_all(unfinishedFolder(item), failure);
  fs::remove(attempt(item, "failure.txt"), failure);
  // A folder without arguments.txt is none of ours.
  if (fs::exists(folder(item)))
    throw DataError(folder(item).string() + ": exists and is not the result of a batch");
}

void RunStore::finish(const WorkItem& item) const {
  writeFileAtomically(unfinishedFolder(item) / kArgumentsFile, commandText(item));
  makeFolder(folder(item).parent_path());
  std::error_code failure;
  fs::rename(unfinishedFolder(item), folder(item), failure);
  if (failure)
    throw DataError(folder(item).string() + ": cannot be completed: " + failure.message());
}

void RunStore::fail(const WorkItem& item, const std::string& why) const {
  writeFileAtomically(attempt(item, "failure.txt"), why + "\n");
}

std::optional<RunLock> RunLock::acquire(const RunStore& store, const WorkItem& item) {
  const fs::path folder = store.work() / ".runs" / item.name;
  makeFolder(folder);
  const fs::path file = folder / "lock";
  const int descriptor = ::open(file.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0666);
  if (descriptor < 0) throw DataError(file.string() + ": cannot be opened");
  RunLock lock(descriptor);
  if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) return std::nullopt;
  return lock;
}

RunLock::~RunLock() {
  if (file_ >= 0) ::close(file_);
}

RunLock::RunLock(RunLock&& other) noexcept : file_(other.file_) { other.file_ = -1; }

}  // namespace dynemo
