// Where a rawlog keeps what it stores outside of itself.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace dynemo {

/// Finds images and clouds that observations name by file. MRPT's own lookup goes through a base
/// folder that is global to the process (mrpt::io::setLazyLoadPathBase); absolute paths make it
/// unnecessary.
class ExternalFiles {
 public:
  ExternalFiles() = default;
  /// The folder beside the rawlog, by the rules of CRawlog::detectImagesDirectory: NAME_Images,
  /// NAME_images, NAME_IMAGES, else Images.
  explicit ExternalFiles(const std::filesystem::path& rawlog);

  const std::filesystem::path& folder() const { return folder_; }
  /// Absolute path of an existing regular file.
  std::optional<std::filesystem::path> find(const std::string& stored_name) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace dynemo
