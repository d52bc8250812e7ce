#include "dynemo/prep/external_references.h"

#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationStereoImages.h>

namespace dynemo {
namespace {

using namespace mrpt::obs;

std::vector<mrpt::img::CImage*> images(CObservation& observation) {
  if (auto* o = dynamic_cast<CObservationImage*>(&observation)) return {&o->image};
  if (auto* o = dynamic_cast<CObservationStereoImages*>(&observation))
    return {&o->imageLeft, &o->imageRight, &o->imageDisparity};
  if (auto* o = dynamic_cast<CObservation3DRangeScan*>(&observation))
    return {&o->intensityImage, &o->confidenceImage};
  return {};
}

}  // namespace

std::vector<std::string> externalFiles(const CObservation& observation) {
  std::vector<std::string> names;
  for (const auto* image : images(const_cast<CObservation&>(observation)))
    if (image->isExternallyStored()) names.push_back(image->getExternalStorageFile());
  if (const auto* o = dynamic_cast<const CObservation3DRangeScan*>(&observation)) {
    if (o->points3D_isExternallyStored()) names.push_back(o->points3D_getExternalStorageFile());
    if (o->rangeImage_isExternallyStored()) {
      names.push_back(o->rangeImage_getExternalStorageFile(""));
      for (const auto& [layer, range] : o->rangeImageOtherLayers)
        names.push_back(o->rangeImage_getExternalStorageFile(layer));
    }
  }
  if (const auto* o = dynamic_cast<const CObservationPointCloud*>(&observation))
    if (o->isExternallyStored()) names.push_back(o->getExternalStorageFile());
  return names;
}

bool renameExternalImage(CObservation& observation, const std::string& old_name,
                         const std::string& new_name) {
  for (auto* image : images(observation)) {
    if (!image->isExternallyStored() || image->getExternalStorageFile() != old_name) continue;
    image->setExternalStorage(new_name);
    return true;
  }
  return false;
}

}  // namespace dynemo
