#include "picture_overlay.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace dynemo {
namespace {

constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
const cv::Scalar kInk(48, 36, 29), kPaper(255, 255, 255);

cv::Scalar toScalar(std::uint32_t rgb) {
  return {static_cast<double>(rgb & 255u), static_cast<double>(rgb >> 8u & 255u),
          static_cast<double>(rgb >> 16u & 255u)};
}

/// Text size that suits the picture's height.
double fontScale(const cv::Mat& picture) { return std::clamp(picture.rows / 1900.0, 0.3, 1.2); }

cv::Size sizeOf(const std::string& text, double scale) {
  int baseline = 0;
  return cv::getTextSize(text, kFont, scale, 1, &baseline);
}

void write(cv::Mat& picture, const std::string& text, cv::Point at, double scale,
           const cv::Scalar& color = kInk) {
  cv::putText(picture, text, at, kFont, scale, color, 1, cv::LINE_AA);
}

/// A translucent plate for text.
void plate(cv::Mat& picture, const cv::Rect& box) {
  constexpr double kOpacity = 0.82;
  const cv::Rect inside = box & cv::Rect(0, 0, picture.cols, picture.rows);
  if (inside.empty()) return;
  cv::Mat part = picture(inside);
  cv::addWeighted(cv::Mat(part.size(), part.type(), kPaper), kOpacity, part, 1.0 - kOpacity, 0.0,
                  part);
}

/// The box at the nearest height over or under the wanted place where it covers no other.
cv::Rect freePlace(cv::Rect box, const std::vector<cv::Rect>& taken) {
  const cv::Rect wanted = box;
  constexpr int kTries = 60;
  for (int i = 0; i < kTries; ++i) {
    const int step = (i + 1) / 2 * (i % 2 == 1 ? -1 : 1);
    box.y = wanted.y + step * wanted.height / 2;
    const bool covers = std::any_of(taken.begin(), taken.end(), [&](const cv::Rect& other) {
      return (box & other).area() > 0;
    });
    if (!covers) return box;
  }
  return wanted;
}

}  // namespace

void drawLabels(cv::Mat& picture, const PictureCamera& camera,
                const std::vector<PictureLabel>& labels) {
  const double scale = fontScale(picture);
  const int pad = std::max(2, static_cast<int>(8 * scale));
  std::vector<cv::Rect> taken;
  for (const PictureLabel& label : labels) {
    const auto at = camera.project(label.p_map);
    if (!at || at->x() < 0 || at->y() < 0 || at->x() >= picture.cols || at->y() >= picture.rows)
      continue;
    const cv::Size size = sizeOf(label.text, scale);
    const cv::Point anchor(static_cast<int>(at->x()), static_cast<int>(at->y()));
    const cv::Rect wanted(anchor.x - size.width / 2 - pad, anchor.y - size.height - 4 * pad,
                          size.width + 2 * pad, size.height + 2 * pad);
    const cv::Rect box = freePlace(wanted, taken);
    taken.push_back(box);
    cv::line(picture, anchor, {anchor.x, box.y + box.height}, toScalar(label.rgb), 1, cv::LINE_AA);
    plate(picture, box);
    cv::line(picture, {box.x, box.y + box.height}, {box.x + box.width, box.y + box.height},
             toScalar(label.rgb), 2, cv::LINE_AA);
    write(picture, label.text, {box.x + pad, box.y + box.height - pad}, scale);
  }
}

void drawLegend(cv::Mat& picture, const std::string& title,
                const std::vector<LegendEntry>& entries) {
  const double scale = fontScale(picture);
  const int pad = std::max(4, static_cast<int>(18 * scale));
  const int line = static_cast<int>(2.0 * sizeOf("Ag", scale).height);
  const int swatch = 2 * line;
  int width = sizeOf(title, scale).width;
  for (const LegendEntry& e : entries)
    width = std::max(width, sizeOf(e.text, scale).width + swatch + pad);
  const int rows = static_cast<int>(entries.size()) + 1;
  plate(picture, {0, 0, width + 2 * pad, rows * line + 2 * pad});
  int y = pad + line / 2 + sizeOf("Ag", scale).height / 2;
  write(picture, title, {pad, y}, scale);
  for (const LegendEntry& e : entries) {
    y += line;
    const int middle = y - sizeOf("A", scale).height / 2;
    cv::line(picture, {pad, middle}, {pad + swatch, middle}, toScalar(e.rgb), 3, cv::LINE_AA);
    write(picture, e.text, {2 * pad + swatch, y}, scale);
  }
}

void drawScale(cv::Mat& picture, const PictureCamera& camera) {
  const double px_per_m = camera.focal_px / camera.distance_m;
  constexpr double kWanted = 0.15;  // of the width
  const double wanted_m = kWanted * picture.cols / px_per_m;
  const double decade = std::pow(10.0, std::floor(std::log10(wanted_m)));
  const double length_m = wanted_m >= 5 * decade   ? 5 * decade
                          : wanted_m >= 2 * decade ? 2 * decade
                                                   : decade;
  const double scale = fontScale(picture);
  const int pad = std::max(4, static_cast<int>(18 * scale));
  const int length_px = static_cast<int>(std::lround(length_m * px_per_m));
  const int y = picture.rows - 2 * pad;
  char text[32];
  std::snprintf(text, sizeof(text), "%g m", length_m);
  const int text_height = sizeOf(text, scale).height;
  plate(picture, {pad, y - text_height - 2 * pad, length_px + 2 * pad, text_height + 3 * pad});
  cv::line(picture, {2 * pad, y}, {2 * pad + length_px, y}, kInk, 2, cv::LINE_AA);
  for (const int x : {2 * pad, 2 * pad + length_px})
    cv::line(picture, {x, y - pad / 3}, {x, y + pad / 3}, kInk, 2, cv::LINE_AA);
  write(picture, text, {2 * pad, y - pad / 2}, scale);
}

}  // namespace dynemo
