#include "dynemo/prep/rawlog_output.h"

#include <fcntl.h>
#include <mrpt/img/CImage.h>
#include <mrpt/io/CStream.h>
#include <mrpt/serialization/CArchive.h>
#include <mrpt/serialization/archiveFrom_std_streams.h>
#include <unistd.h>
#include <zlib.h>

#include <cerrno>
#include <fstream>
#include <stdexcept>
#include <system_error>
#include <utility>
#include <vector>

#include "dynemo/core/error.h"
#include "dynemo/prep/external_references.h"

namespace dynemo {

namespace fs = std::filesystem;

/// Unlike MRPT's file streams it notices a full disk at every step and at the end.
class RawlogOutput::Stream : public mrpt::io::CStream {
 public:
  Stream(const fs::path& file, bool compressed) : file_(file) {
    // "T" writes without compression.
    handle_ = gzopen(file.c_str(), compressed ? "wb1" : "wbT");
    if (handle_ == nullptr) throw DataError(file.string() + ": cannot be created");
    gzbuffer(handle_, 1 << 16);
  }
  ~Stream() override {
    if (handle_ != nullptr) gzclose(handle_);
  }
  size_t Read(void*, size_t) override { throw std::logic_error("an output is only written"); }
  size_t Write(const void* buffer, size_t count) override {
    const auto* bytes = static_cast<const char*>(buffer);
    for (size_t done = 0; done < count;) {
      const auto step = static_cast<unsigned>(std::min<size_t>(count - done, 1 << 30));
      if (gzwrite(handle_, bytes + done, step) != static_cast<int>(step)) {
        const int error = errno;
        int code = Z_OK;
        gzerror(handle_, &code);
        fail(code, error);
      }
      done += step;
    }
    written_ += count;
    return count;
  }
  void close() {
    const int result = gzclose(std::exchange(handle_, nullptr));
    if (result != Z_OK) fail(result, errno);
  }
  uint64_t Seek(int64_t, TSeekOrigin) override { throw std::logic_error("written in sequence"); }
  uint64_t getTotalBytesCount() const override { return written_; }
  uint64_t getPosition() const override { return written_; }

 private:
  [[noreturn]] void fail(int zlib_code, int error) const {
    throw DataError(
        file_.string() + ": cannot be written: " +
        (zlib_code == Z_ERRNO ? std::generic_category().message(error) : "compression failed"));
  }
  fs::path file_;
  gzFile handle_ = nullptr;
  uint64_t written_ = 0;
};

namespace {

/// While it lives, MRPT stores images without loss.
class LosslessImages {
 public:
  LosslessImages() : before_(mrpt::img::CImage::DISABLE_JPEG_COMPRESSION()) {
    mrpt::img::CImage::DISABLE_JPEG_COMPRESSION(true);
  }
  ~LosslessImages() { mrpt::img::CImage::DISABLE_JPEG_COMPRESSION(before_); }
  LosslessImages(const LosslessImages&) = delete;
  LosslessImages& operator=(const LosslessImages&) = delete;

 private:
  bool before_;
};

bool sameContent(const fs::path& a, const fs::path& b) {
  if (fs::file_size(a) != fs::file_size(b)) return false;
  std::ifstream in_a(a, std::ios::binary), in_b(b, std::ios::binary);
  return std::equal(std::istreambuf_iterator<char>(in_a), std::istreambuf_iterator<char>(),
                    std::istreambuf_iterator<char>(in_b));
}

/// std::filesystem::copy_file calls a disk that gets full on the way an input/output error.
std::error_code copyFile(const fs::path& from, const fs::path& to) {
  const auto error = [] { return std::error_code(errno, std::generic_category()); };
  const int in = ::open(from.c_str(), O_RDONLY | O_CLOEXEC);
  if (in < 0) return error();
  const int out = ::open(to.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  std::error_code failure = out < 0 ? error() : std::error_code();
  std::vector<char> buffer(1 << 16);
  while (!failure) {
    const ssize_t got = ::read(in, buffer.data(), buffer.size());
    if (got < 0) failure = error();
    if (got <= 0) break;
    for (ssize_t done = 0; done < got && !failure;) {
      const ssize_t put = ::write(out, buffer.data() + done, static_cast<std::size_t>(got - done));
      if (put < 0) failure = error();
      if (put > 0) done += put;
    }
  }
  ::close(in);
  if (out >= 0 && ::close(out) != 0 && !failure) failure = error();
  return failure;
}

/// Whether a name stays inside of the folder it is put under.
bool staysInside(const fs::path& name) {
  if (name.is_absolute()) return false;
  for (const auto& part : name.lexically_normal())
    if (part == "..") return false;
  return true;
}

}  // namespace

RawlogOutput::RawlogOutput(const fs::path& rawlog, bool compressed, ImageTransfer transfer)
    : file_(rawlog), transfer_(transfer) {
  if (file_.extension() != ".rawlog")
    throw ConfigError(file_.string() + ": the name of a rawlog must end in .rawlog");
  const fs::path folder = fs::absolute(file_).parent_path();
  images_ = folder / (file_.stem().string() + "_Images");
  part_ = file_.string() + ".part";
  images_part_ = images_.string() + ".part";
  for (const fs::path& taken : {file_, images_})
    if (fs::exists(fs::symlink_status(taken)))
      throw DataError(taken.string() + ": exists already and is not overwritten");
  std::error_code failure;
  fs::create_directories(folder, failure);
  fs::remove_all(images_part_, failure);
  stream_ = std::make_unique<Stream>(part_, compressed);
}

RawlogOutput::~RawlogOutput() {
  stream_.reset();
  if (committed_) return;
  std::error_code ignored;
  fs::remove(part_, ignored);
  if (images_made_) fs::remove_all(images_part_, ignored);
}

const fs::path& RawlogOutput::imageFolder() {
  if (!images_made_) {
    std::error_code failure;
    fs::create_directories(images_part_, failure);
    if (failure) throw DataError(images_part_.string() + ": cannot be made: " + failure.message());
    images_made_ = true;
  }
  return images_part_;
}

std::string RawlogOutput::freeImageName(const std::string& stem, const std::string& extension,
                                        const ExternalFiles& input_files) {
  std::string name = stem + extension;
  for (int i = 2; fs::exists(imageFolder() / name) || input_files.find(name); ++i)
    name = stem + "_" + std::to_string(i) + extension;
  return name;
}

void RawlogOutput::write(RawlogPiece piece, const ExternalFiles& input_files,
                         WarningCounter& warnings) {
  takeOverFiles(piece, input_files, warnings);
  for (const StoredObject& stored : piece.objects) {
    if (stored.edited)
      write(*stored.entry.object);
    else {
      stream_->Write(stored.entry.bytes.data(), stored.entry.bytes.size());
      ++objects_;
    }
  }
}

void RawlogOutput::write(const mrpt::serialization::CSerializable& object) {
  const LosslessImages lossless;
  mrpt::serialization::archiveFrom<mrpt::io::CStream>(*stream_).WriteObject(object);
  ++objects_;
}

void RawlogOutput::takeOverFiles(RawlogPiece& piece, const ExternalFiles& input_files,
                                 WarningCounter& warnings) {
  editObservations(piece, [&](mrpt::obs::CObservation& o) {
    EditResult result = EditResult::kUnchanged;
    for (const std::string& name : externalFiles(o))
      if (takeOver(o, name, input_files, warnings)) result = EditResult::kEdited;
    return result;
  });
}

/// Returns whether the observation had to be changed.
bool RawlogOutput::takeOver(mrpt::obs::CObservation& observation, const std::string& name,
                            const ExternalFiles& input_files, WarningCounter& warnings) {
  if (fs::path(name).is_absolute()) return false;
  // What an edit has put into the new folder itself is there already.
  const auto source = input_files.find(name);
  if (!source) {
    if (!images_made_ || !fs::exists(images_part_ / name))
      warnings.count("file of '" + observation.sensorLabel + "' not found, left out", name);
    return false;
  }
  if (!staysInside(name)) {
    warnings.count("file name that leaves the image folder, file not copied", name);
    return false;
  }
  fs::path target = imageFolder() / name;
  bool renamed = false;
  if (fs::exists(target)) {
    if (sameContent(*source, target)) return false;
    const fs::path path(name);
    const std::string free = freeImageName((path.parent_path() / path.stem()).string(),
                                           path.extension().string(), input_files);
    if (!renameExternalImage(observation, name, free))
      throw DataError(file_.string() + ": two different files are named " + name);
    target = imageFolder() / free;
    renamed = true;
  }
  std::error_code failure;
  fs::create_directories(target.parent_path(), failure);
  if (transfer_ == ImageTransfer::kHardLink) fs::create_hard_link(*source, target, failure);
  if (transfer_ == ImageTransfer::kCopy || failure) failure = copyFile(*source, target);
  if (failure) throw DataError(target.string() + ": cannot be written: " + failure.message());
  return renamed;
}

void RawlogOutput::commit() {
  stream_->close();
  std::error_code failure;
  if (images_made_) fs::rename(images_part_, images_, failure);
  if (!failure) fs::rename(part_, file_, failure);
  if (failure) throw DataError(file_.string() + ": cannot be completed: " + failure.message());
  committed_ = true;
}

}  // namespace dynemo
