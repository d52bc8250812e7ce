// PNG: the map from above, before and after its loop closures, with a detail of where they changed
// it most.
#include <array>
#include <cmath>
#include <cstdio>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "dynemo/core/output_file.h"
#include "dynemo/graph/edge_relative_pose.h"
#include "factories.h"
#include "map_raster.h"

namespace dynemo {
namespace {

constexpr std::size_t kPointBudget = 4'000'000;
constexpr int kPanel_px = 1200;  ///< longer side
constexpr int kDetailHeight_px = 560;
constexpr double kMargin_m = 0.5;
constexpr double kDetail_m = 5.0;  ///< width
constexpr double kCell_m = 0.25;   ///< of the search for it
constexpr int kGap_px = 24, kTitle_px = 56;
const cv::Scalar kInk(60, 55, 50), kPath(120, 120, 120), kClosure(60, 160, 20),
    kFrame(190, 190, 190);

std::vector<Pose3> estimates(const CSceneGraph& graph) {
  std::vector<Pose3> poses;
  for (const auto& keyframe : graph.keyframes()) poses.push_back(keyframe->T_map_base());
  return poses;
}

cv::Point fixedPoint(const MapView& view, const Vector3& p_map) {
  const cv::Point2d p = view.pixel(p_map);
  return {static_cast<int>(std::lround(p.x * 16)), static_cast<int>(std::lround(p.y * 16))};
}

void line(cv::Mat& picture, const MapView& view, const Vector3& a, const Vector3& b,
          const cv::Scalar& color, int width_px) {
  cv::line(picture, fixedPoint(view, a), fixedPoint(view, b), color, width_px, cv::LINE_AA, 4);
}

void write(cv::Mat& picture, const std::string& text, cv::Point at, double scale,
           const cv::Scalar& color = kInk) {
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, scale, color, scale > 0.9 ? 2 : 1,
              cv::LINE_AA);
}

/// The largest of 1, 2, 5, 10, … m that takes at most a fourth of the width.
double scaleBar_m(const MapView& view) {
  const double most_m = 0.25 * view.size().width * view.pixel_m;
  double bar_m = std::pow(10.0, std::floor(std::log10(most_m)));
  for (const double factor : {5.0, 2.0}) {
    if (factor * bar_m <= most_m) return factor * bar_m;
  }
  return bar_m;
}

void drawScaleBar(cv::Mat& picture, const MapView& view) {
  const double bar_m = scaleBar_m(view);
  const int length_px = static_cast<int>(std::lround(bar_m / view.pixel_m));
  const cv::Point left(20, picture.rows - 22);
  cv::rectangle(picture, left + cv::Point(-8, -26), left + cv::Point(length_px + 8, 12),
                cv::Scalar::all(255), cv::FILLED);
  cv::line(picture, left, left + cv::Point(length_px, 0), kInk, 3);
  char text[32];
  std::snprintf(text, sizeof(text), "%g m", bar_m);
  write(picture, text, left + cv::Point(2, -9), 0.55);
}

/// One panel: structure, path, and closures where they are in force.
cv::Mat panel(const CSceneGraph& graph, const std::vector<RasterPoint>& points,
              const std::vector<Pose3>& poses, const MapView& view, bool closures) {
  cv::Mat picture = paintStructure(points, poses, view);
  for (std::size_t k = 1; k < poses.size(); ++k)
    line(picture, view, poses[k - 1].t, poses[k].t, kPath, 1);
  if (closures) {
    for (const auto& slot : graph.edgeSlots()) {
      const auto* edge = dynamic_cast<const CEdgeLoopClosure*>(slot.get());
      if (!edge) continue;
      line(picture, view, graph.getNode<CNodeKeyframe>(edge->nodes[0]).T_map_base().t,
           graph.getNode<CNodeKeyframe>(edge->nodes[1]).T_map_base().t, kClosure, 2);
    }
  }
  drawScaleBar(picture, view);
  cv::rectangle(picture, {0, 0}, {picture.cols - 1, picture.rows - 1}, kFrame, 1);
  return picture;
}

/// The whole structure and path, at a resolution that fits the panel.
MapView wholeMap(const std::vector<RasterPoint>& points, const std::vector<Pose3>& poses) {
  std::vector<double> x, y;
  for (const RasterPoint& point : points) {
    const Vector3 p = poses[point.keyframe] * point.p_base.cast<double>();
    x.push_back(p.x());
    y.push_back(p.y());
  }
  // Single far points, seen through a window, are not to make everything small.
  const auto quantile = [](std::vector<double>& v, double q) {
    const auto at = v.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(v.size() - 1));
    std::nth_element(v.begin(), at, v.end());
    return *at;
  };
  MapView view;
  for (const Pose3& T : poses) view.area_m.extend(T.t.head<2>());
  if (!x.empty()) {
    view.area_m.extend(Vector2(quantile(x, 0.002), quantile(y, 0.002)));
    view.area_m.extend(Vector2(quantile(x, 0.998), quantile(y, 0.998)));
  }
  if (view.area_m.isEmpty()) view.area_m.extend(Vector2::Zero());
  view.area_m.min().array() -= kMargin_m;
  view.area_m.max().array() += kMargin_m;
  view.pixel_m = view.area_m.sizes().maxCoeff() / kPanel_px;
  return view;
}

/// Where the closures moved the most structure: the window, as wide as the panel, with the largest
/// sum of displacements.
MapView detail(const std::vector<RasterPoint>& points, const std::vector<Pose3>& before,
               const std::vector<Pose3>& after, const MapView& whole) {
  MapView view;
  view.pixel_m = kDetail_m / whole.size().width;
  const Vector2 half(0.5 * kDetail_m, 0.5 * kDetailHeight_px * view.pixel_m);
  MapView cells = whole;
  cells.pixel_m = kCell_m;
  cv::Mat moved(cells.size(), CV_32FC1, cv::Scalar(0));
  for (const RasterPoint& point : points) {
    const Vector3 p = after[point.keyframe] * point.p_base.cast<double>();
    const cv::Point cell(cells.pixel(p));
    if (!cv::Rect({0, 0}, moved.size()).contains(cell)) continue;
    const Vector3 p_before = before[point.keyframe] * point.p_base.cast<double>();
    moved.at<float>(cell) += static_cast<float>((p - p_before).norm());
  }
  const Eigen::Vector2d window = 2.0 * half / kCell_m;
  cv::boxFilter(moved, moved, -1,
                cv::Size(static_cast<int>(window.x()) | 1, static_cast<int>(window.y()) | 1),
                {-1, -1}, false, cv::BORDER_CONSTANT);
  cv::Point most;
  cv::minMaxLoc(moved, nullptr, nullptr, nullptr, &most);
  const Vector2 there(cells.area_m.min().x() + (most.x + 0.5) * kCell_m,
                      cells.area_m.max().y() - (most.y + 0.5) * kCell_m);
  // Inside of the whole, as far as that is large enough.
  const Vector2 low = whole.area_m.min() + half, high = whole.area_m.max() - half;
  const Vector2 center = there.cwiseMin(high).cwiseMax(low);
  view.area_m = Eigen::AlignedBox2d(center - half, center + half);
  return view;
}

void outline(cv::Mat& picture, const MapView& whole, const MapView& part) {
  const auto corner = [&](const Vector2& p) {
    return cv::Point(whole.pixel(Vector3(p.x(), p.y(), 0)));
  };
  cv::rectangle(picture, corner(part.area_m.min()), corner(part.area_m.max()), kInk, 1,
                cv::LINE_AA);
}

void drawLegend(cv::Mat& sheet, cv::Point at) {
  constexpr int kLength_px = 200;
  write(sheet, "first", at + cv::Point(0, 6), 0.55);
  for (int i = 0; i < kLength_px; ++i) {
    const cv::Vec3f c = colorOfTime(static_cast<std::size_t>(i), kLength_px);
    cv::line(sheet, at + cv::Point(52 + i, -8), at + cv::Point(52 + i, 8), cv::Scalar(c));
  }
  write(sheet, "last keyframe", at + cv::Point(52 + kLength_px + 10, 6), 0.55);
}

class MapFigureExporter : public Exporter {
 public:
  explicit MapFigureExporter(const ExportParams& params) : params_(params) {}
  std::string fileName() const override { return "map.png"; }

  void write(const RunResult& run, const std::filesystem::path& file) const override {
    const PointOwners& owners = pointOwners(run, params_.structure, params_.query);
    const auto points = structurePoints(run.graph, owners, kPointBudget);
    const std::vector<Pose3> after = estimates(run.graph);
    const MapView whole = wholeMap(points, after);
    const bool closed = run.keyframes_without_closures.size() == after.size() && !after.empty();
    cv::Mat sheet;
    if (closed) {
      const auto& without = run.keyframes_without_closures;
      sheet = beforeAndAfter(run.graph, points, {without.begin(), without.end()}, after, whole);
    } else {
      const cv::Mat one = panel(run.graph, points, after, whole, false);
      sheet = blank(one.cols + 2 * kGap_px, kTitle_px + one.rows + kGap_px);
      place(sheet, one, "map", {kGap_px, kTitle_px});
      drawLegend(sheet, {sheet.cols - 420 - kGap_px, kTitle_px / 2});
    }
    std::vector<std::uint8_t> png;
    cv::imencode(".png", sheet, png);
    writeFileAtomically(file, std::string(png.begin(), png.end()));
  }

 private:
  static cv::Mat blank(int width, int height) {
    return {std::max(height, 1), std::max(width, 480), CV_8UC3, cv::Scalar::all(255)};
  }

  static void place(cv::Mat& sheet, const cv::Mat& picture, const std::string& title,
                    cv::Point at) {
    picture.copyTo(sheet(cv::Rect(at, picture.size())));
    if (!title.empty()) dynemo::write(sheet, title, at + cv::Point(0, -18), 0.95);
  }

  static cv::Mat beforeAndAfter(const CSceneGraph& graph, const std::vector<RasterPoint>& points,
                                const std::vector<Pose3>& before, const std::vector<Pose3>& after,
                                const MapView& whole) {
    const std::array<cv::Mat, 2> maps = {panel(graph, points, before, whole, false),
                                         panel(graph, points, after, whole, true)};
    const int width = maps[0].cols, height = maps[0].rows;
    const MapView part = detail(points, before, after, whole);
    const std::array<cv::Mat, 2> details = {panel(graph, points, before, part, false),
                                            panel(graph, points, after, part, true)};
    cv::Mat sheet =
        blank(2 * width + 3 * kGap_px, kTitle_px + height + kGap_px + details[0].rows + kGap_px);
    for (int i = 0; i < 2; ++i) {
      cv::Mat map = maps[static_cast<std::size_t>(i)];
      outline(map, whole, part);
      const int x = kGap_px + i * (width + kGap_px);
      place(sheet, map, i == 0 ? "before loop closure" : "after loop closure", {x, kTitle_px});
      place(sheet, details[static_cast<std::size_t>(i)], "", {x, kTitle_px + height + kGap_px});
    }
    drawLegend(sheet, {sheet.cols - 400 - kGap_px, kTitle_px / 2});
    return sheet;
  }

  ExportParams params_;
};

}  // namespace

std::unique_ptr<Exporter> makeMapFigureExporter(const ExportParams& params) {
  return std::make_unique<MapFigureExporter>(params);
}

}  // namespace dynemo
