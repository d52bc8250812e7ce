#include <mrpt/obs/CObservationImage.h>
#include <mrpt/obs/CObservationStereoImages.h>

#include <opencv2/imgcodecs.hpp>

#include "dynemo/core/error.h"
#include "rewriting.h"

namespace dynemo {

namespace fs = std::filesystem;

namespace {

struct NamedImage {
  mrpt::img::CImage* image;
  const char* suffix;
};

std::vector<NamedImage> imagesOf(mrpt::obs::CObservation& observation) {
  std::vector<NamedImage> all;
  if (auto* o = dynamic_cast<mrpt::obs::CObservationImage*>(&observation)) all = {{&o->image, ""}};
  if (auto* o = dynamic_cast<mrpt::obs::CObservationStereoImages*>(&observation))
    all = {
        {&o->imageLeft, "_left"}, {&o->imageRight, "_right"}, {&o->imageDisparity, "_disparity"}};
  return all;
}

/// A label as part of a file name.
std::string fileNamePart(const std::string& label) {
  std::string name = label.empty() ? "image" : label;
  for (char& c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '-' && c != '_' && c != '.')
      c = '_';
  return name;
}

std::string stampText(const mrpt::obs::CObservation& observation) {
  const auto stamp = validStamp(observation.timestamp);
  return stamp ? stamp->text() : "unknown";
}

}  // namespace

RewriteReport externalizeImages(const fs::path& input, const fs::path& output, ImageFormat format,
                                int jpeg_quality, const RewriteOptions& options) {
  RewriteReport report;
  WarningCounter warnings;
  PieceReader reader(input, warnings);
  const ExternalFiles files(input);
  RawlogOutput out(output, options.compressed.value_or(reader.compressed()), options.images);
  const std::string extension = format == ImageFormat::kPng ? ".png" : ".jpg";
  const std::vector<int> encoding = {cv::IMWRITE_JPEG_QUALITY, jpeg_quality};

  std::uint64_t in_files = 0;
  const auto edit = [&](mrpt::obs::CObservation& o) {
    EditResult result = EditResult::kUnchanged;
    for (const NamedImage& named : imagesOf(o)) {
      if (named.image->isExternallyStored()) {
        ++in_files;
        continue;
      }
      if (named.image->isEmpty()) continue;
      const std::string name = out.freeImageName(
          fileNamePart(o.sensorLabel) + "_" + stampText(o) + named.suffix, extension, files);
      const auto pixels = named.image->asCvMat<cv::Mat>(mrpt::img::SHALLOW_COPY);
      if (!cv::imwrite((out.imageFolder() / name).string(), pixels, encoding))
        throw DataError((out.imageFolder() / name).string() + ": cannot be written");
      named.image->setExternalStorage(name);
      result = EditResult::kEdited;
    }
    if (result == EditResult::kEdited) ++report.edited[o.sensorLabel];
    return result;
  };
  rewrite(
      reader, [&](RawlogPiece& piece) { return editObservations(piece, edit) ? &out : nullptr; },
      warnings, report);
  if (report.edited.empty() && in_files == 0)
    throw DataError(input.string() +
                    ": holds no image of class CObservationImage or CObservationStereoImages");
  warnings.count("image that is in a file already and stays there", in_files);
  out.commit();
  report.written = out.objectsWritten();
  report.warnings = warnings.counts();
  report.files = {output};
  return report;
}

}  // namespace dynemo
