// The recorded half of a dataset: rawlog, images, entity file.
#pragma once

#include <mrpt/io/CFileGZOutputStream.h>

#include <filesystem>
#include <string>

#include "dynemo/simulation/world.h"
#include "recording.h"

namespace dynemo::simulation {

/// NAME.rawlog and NAME_Images/. The rawlog has a temporary name until finish().
class RawlogWriter {
 public:
  /// Throws DataError when the files cannot be created.
  RawlogWriter(const std::filesystem::path& folder, const std::string& name);
  ~RawlogWriter();
  RawlogWriter(const RawlogWriter&) = delete;
  RawlogWriter& operator=(const RawlogWriter&) = delete;

  void write(const Reading& reading);
  void finish();

 private:
  std::filesystem::path rawlog_, temporary_, images_;
  mrpt::io::CFileGZOutputStream out_;
  bool finished_ = false;
};

/// The entity file for dynemo-slam.
std::string entityYaml(const World& world);

/// What dynemo-slam cannot find in the rawlog: beam elevations, the sweep's rate.
std::string slamConfigYaml(const World& world);

}  // namespace dynemo::simulation
