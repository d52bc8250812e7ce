// Planes of scans, kept in a folder with one small file per scan.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "dynemo/perception/plane_extractor.h"

namespace dynemo {

/// Reads the planes of a scan that has been seen before, with the same `identity`, and else
/// extracts and writes them. Runs may share the folder: each file appears at once, and does not
/// change. A damaged file is written anew; throws DataError when it cannot be.
class PlaneCache : public PlaneExtractor {
 public:
  PlaneCache(std::filesystem::path folder, const std::string& identity,
             std::unique_ptr<PlaneExtractor> inner);
  std::vector<PlaneObservation> extract(const Scan& scan) const override;

 private:
  std::filesystem::path folder_;
  std::uint64_t seed_;
  std::unique_ptr<PlaneExtractor> inner_;
};

}  // namespace dynemo
