// A rawlog in the making, with the folder of its images.
#pragma once

#include <mrpt/serialization/CSerializable.h>

#include <filesystem>
#include <memory>
#include <string>

#include "dynemo/ingest/external_files.h"
#include "dynemo/ingest/warning_counter.h"
#include "dynemo/prep/rawlog_pieces.h"

namespace dynemo {

enum class ImageTransfer {
  kCopy,
  kHardLink  ///< no second copy on the disk; copied where linking is not possible
};

/// Writes NAME.rawlog and NAME_Images under temporary names and renames both when it is committed;
/// until then, and without a commit, nothing of them is to be seen.
class RawlogOutput {
 public:
  /// Throws DataError when the rawlog or its image folder exists already, or cannot be made, and
  /// ConfigError when the name does not end in .rawlog.
  RawlogOutput(const std::filesystem::path& rawlog, bool compressed,
               ImageTransfer transfer = ImageTransfer::kCopy);
  ~RawlogOutput();
  RawlogOutput(const RawlogOutput&) = delete;
  RawlogOutput& operator=(const RawlogOutput&) = delete;

  /// Appends the piece and takes over the files it refers to from the input's folder. A file that
  /// is missing there is counted; an image whose name is taken by another content gets another
  /// name. Throws DataError when writing fails.
  void write(RawlogPiece piece, const ExternalFiles& input_files, WarningCounter& warnings);
  void write(const mrpt::serialization::CSerializable& object);

  /// The folder that becomes NAME_Images; made on the first call.
  const std::filesystem::path& imageFolder();
  /// A file name that neither the image folder nor the input's has: `stem` + `extension`, or with a
  /// number between.
  std::string freeImageName(const std::string& stem, const std::string& extension,
                            const ExternalFiles& input_files);

  /// Observations and other objects written so far.
  std::uint64_t objectsWritten() const { return objects_; }
  const std::filesystem::path& file() const { return file_; }

  /// Completes both files. Throws DataError when that fails.
  void commit();

 private:
  void takeOverFiles(RawlogPiece& piece, const ExternalFiles& input_files,
                     WarningCounter& warnings);
  bool takeOver(mrpt::obs::CObservation& observation, const std::string& name,
                const ExternalFiles& input_files, WarningCounter& warnings);

  class Stream;
  std::filesystem::path file_, part_, images_, images_part_;
  ImageTransfer transfer_;
  std::unique_ptr<Stream> stream_;
  std::uint64_t objects_ = 0;
  bool images_made_ = false, committed_ = false;
};

}  // namespace dynemo
