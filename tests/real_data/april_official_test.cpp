#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <regex>

#include "dynemo/perception/tag_finder.h"
#include "sample_dataset.h"

namespace dynemo {
namespace {

constexpr std::size_t kExpectedTags = 47, kMinFound = 46;
constexpr double kSameTag_px = 5.0;
constexpr double kMedianWithoutRefinement_px = 0.006, kMedianWithRefinement_px = 0.5;
/// libapriltag's own coordinates have pixel centres at +½.
constexpr double kPixelCentre = 0.5;

std::vector<TagCornerObservation> readExpected(const std::filesystem::path& file) {
  const std::regex number("-?[0-9]+\\.[0-9]+");
  std::vector<TagCornerObservation> tags;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    std::vector<double> v;
    for (std::sregex_iterator it(line.begin(), line.end(), number), end; it != end; ++it) {
      v.push_back(std::stod(it->str()));
    }
    if (v.size() != 8) continue;
    TagCornerObservation tag;
    tag.tag_id = std::stoi(line);
    for (std::size_t i = 0; i < 4; ++i) tag.corners_px[i] = Vector2(v[2 * i], v[2 * i + 1]);
    tags.push_back(tag);
  }
  return tags;
}

double largestCornerDistance_px(const TagCornerObservation& expected,
                                const TagCornerObservation& found) {
  double largest = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vector2 in_library = found.corners_px[i].array() + kPixelCentre;
    largest = std::max(largest, (in_library - expected.corners_px[i]).norm());
  }
  return largest;
}

struct Comparison {
  std::size_t expected = 0;
  std::vector<double> distance_px;  ///< of the tags that were found
  double median() {
    std::sort(distance_px.begin(), distance_px.end());
    return distance_px.at(distance_px.size() / 2);
  }
};

Comparison compareAll(const std::filesystem::path& folder, const TagFinderParams& params) {
  TagFinder finder("tag36h11", params);
  Comparison result;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".jpg") continue;
    const auto found = finder.find(cv::imread(entry.path().string(), cv::IMREAD_GRAYSCALE));
    auto text = entry.path();
    for (const auto& expected : readExpected(text.replace_extension(".txt"))) {
      ++result.expected;
      double nearest = kSameTag_px;
      for (const FoundTag& tag : found) {
        if (tag.observation.tag_id != expected.tag_id) continue;
        nearest = std::min(nearest, largestCornerDistance_px(expected, tag.observation));
      }
      if (nearest < kSameTag_px) result.distance_px.push_back(nearest);
    }
  }
  return result;
}

class OfficialPhotos : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto folder = test::realDataFolder();
    if (!folder) GTEST_SKIP() << "DYNEMO_REAL_DATA is not set";
    folder_ = *folder / "apriltag" / "april_official";
    params_.decimate = 1.0;
  }
  std::filesystem::path folder_;
  TagFinderParams params_;
};

TEST_F(OfficialPhotos, CornersEqualTheExpectedOnesWithoutRefinement) {
  params_.refine_edges = false;
  Comparison result = compareAll(folder_, params_);
  EXPECT_EQ(result.expected, kExpectedTags);
  EXPECT_GE(result.distance_px.size(), kMinFound);
  EXPECT_LE(result.median(), kMedianWithoutRefinement_px);
}

TEST_F(OfficialPhotos, EdgeRefinementMovesThemByHalfAPixelAtMost) {
  Comparison result = compareAll(folder_, params_);
  EXPECT_GE(result.distance_px.size(), kMinFound);
  EXPECT_LE(result.median(), kMedianWithRefinement_px);
}

}  // namespace
}  // namespace dynemo
