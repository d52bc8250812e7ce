#include "dynemo/perception/tag_finder.h"

#include <apriltag/apriltag.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "dynemo/core/error.h"

namespace dynemo {
namespace {

/// libapriltag counts pixel corners from zero; its pixel centres are at +½.
constexpr double kPixelCentre = 0.5;
/// Smaller images make libapriltag's tiles empty.
constexpr int kMinImageSide_px = 16;

void checkDecimation(double decimate) {
  const bool offered = decimate == 1.5 || (decimate >= 1.0 && decimate == std::floor(decimate));
  if (!offered) {
    throw ConfigError("decimate: " + std::to_string(decimate) + " must be 1.5 or a whole number");
  }
}

/// libapriltag keeps a table of every code with every correctable error: n · Σ C(bits, errors)
/// entries of some 50 bytes, gigabytes for the largest families.
constexpr double kMaxTableEntries = 1e6;

int correctableBits(const apriltag_family_t& family, int wanted) {
  const double bits = family.nbits;
  double errors = 1.0, entries = family.ncodes;
  int corrected = 0;
  while (corrected < wanted) {
    errors *= (bits - corrected) / (corrected + 1);
    entries += family.ncodes * errors;
    if (entries > kMaxTableEntries) break;
    ++corrected;
  }
  return corrected;
}

FoundTag fromLibrary(const apriltag_detection_t& detection) {
  FoundTag tag;
  tag.observation.tag_id = detection.id;
  for (std::size_t i = 0; i < 4; ++i) {
    tag.observation.corners_px[i] =
        Vector2(detection.p[i][0], detection.p[i][1]).array() - kPixelCentre;
  }
  tag.hamming = detection.hamming;
  tag.decision_margin = static_cast<double>(detection.decision_margin);
  return tag;
}

bool before(const FoundTag& a, const FoundTag& b) {
  const auto key = [](const FoundTag& t) {
    return std::tuple(t.observation.tag_id, t.hamming, -t.decision_margin,
                      t.observation.corners_px[0].x(), t.observation.corners_px[0].y());
  };
  return key(a) < key(b);
}

}  // namespace

TagFinder::TagFinder(const std::string& family, const TagFinderParams& params)
    : params_(params),
      family_(makeTagFamily(family)),
      detector_(apriltag_detector_create(), apriltag_detector_destroy) {
  checkDecimation(params.decimate);
  detector_->nthreads = params.threads;
  detector_->quad_decimate = static_cast<float>(params.decimate);
  detector_->quad_sigma = static_cast<float>(params.blur_sigma_px);
  detector_->refine_edges = params.refine_edges;
  detector_->decode_sharpening = params.decode_sharpening;
  detector_->qtp.min_white_black_diff = params.min_white_black_diff;
  apriltag_detector_add_family_bits(detector_.get(), family_.get(),
                                    correctableBits(*family_, params.max_hamming));
}

std::vector<FoundTag> TagFinder::find(const cv::Mat& grey) {
  if (grey.type() != CV_8UC1 || std::min(grey.rows, grey.cols) < kMinImageSide_px) return {};
  image_u8_t view{grey.cols, grey.rows, static_cast<int32_t>(grey.step[0]), grey.data};
  const std::unique_ptr<zarray_t, void (*)(zarray_t*)> detections(
      apriltag_detector_detect(detector_.get(), &view), apriltag_detections_destroy);
  std::vector<FoundTag> tags;
  for (int i = 0; i < zarray_size(detections.get()); ++i) {
    apriltag_detection_t* detection = nullptr;
    zarray_get(detections.get(), i, &detection);
    if (detection->hamming > params_.max_hamming) continue;
    if (static_cast<double>(detection->decision_margin) < params_.min_decision_margin) continue;
    tags.push_back(fromLibrary(*detection));
  }
  std::sort(tags.begin(), tags.end(), before);
  return tags;
}

}  // namespace dynemo
