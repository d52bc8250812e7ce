#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "dynemo/prep/inspection.h"

namespace dynemo {
namespace {

template <class... Values>
std::string format(const char* pattern, Values... values) {
  char text[512];
  std::snprintf(text, sizeof(text), pattern, values...);
  return text;
}

/// No minus before a zero.
std::string fixed(double value, int digits) {
  const std::string text = format("%.*f", digits, value);
  const bool zero = text.find_first_not_of("-0.") == std::string::npos;
  return zero && text[0] == '-' ? text.substr(1) : text;
}

std::string named(const std::string& label) { return label.empty() ? "(no label)" : label; }

std::string poseText(const Pose3& T) {
  constexpr double kDeg = 180.0 / std::numbers::pi;
  const Vector3 ypr = T.R.eulerAngles(2, 1, 0) * kDeg;
  // Of the two sets of angles the one with the pitch within ±90°.
  Vector3 a = ypr;
  if (std::abs(a.y()) > 90.0)
    a = {a.x() > 0 ? a.x() - 180 : a.x() + 180, a.y() > 0 ? 180 - a.y() : -180 - a.y(),
         a.z() > 0 ? a.z() - 180 : a.z() + 180};
  return "(" + fixed(T.t.x(), 3) + " " + fixed(T.t.y(), 3) + " " + fixed(T.t.z(), 3) + ") m, yaw " +
         fixed(a.x(), 1) + " pitch " + fixed(a.y(), 1) + " roll " + fixed(a.z(), 1) + " deg";
}

/// Widths of the columns whose content is not ours.
struct Widths {
  int label = 14, class_name = 24;
};

Widths widths(const Inspection& log) {
  Widths w;
  for (const SensorInspection& s : log.sensors) {
    w.label = std::max(w.label, static_cast<int>(named(s.label).size()));
    w.class_name = std::max(w.class_name, static_cast<int>(s.class_name.size()));
  }
  return w;
}

std::string sensorRow(const SensorInspection& s, const Widths& w) {
  std::string row =
      format("%-*s %-*s %-10s %8llu", w.label, named(s.label).c_str(), w.class_name,
             s.class_name.c_str(), useText(s.use), static_cast<unsigned long long>(s.count));
  row += s.first ? format(" %9.2f %9.1f", s.rate_hz(), s.duration_s()) : "         -         -";
  row += s.use == UseOfSensor::kDetections
             ? "     -        -"
             : format(" %5llu %8.2f", static_cast<unsigned long long>(s.gaps), s.longest_gap_s);
  row += format(" %6llu", static_cast<unsigned long long>(s.jumps_back));
  if (s.other_clock) row += format("  clock %+.3f s", s.clock_offset_s);
  return row + "\n";
}

std::string sensorDetails(const SensorInspection& s, const Widths& w) {
  if (s.use == UseOfSensor::kNotUsed) return {};
  std::string text;
  const std::string lead = format("%-*s ", w.label, named(s.label).c_str());
  if (s.use != UseOfSensor::kOdometry && s.T_base_sensor)
    text += lead + "mounted at " + poseText(*s.T_base_sensor) + "\n";
  if (s.scan && s.count > 0)
    text += lead + format("%llu to %llu points, %.0f on average, %s\n",
                          static_cast<unsigned long long>(s.scan->min_points),
                          static_cast<unsigned long long>(s.scan->max_points),
                          static_cast<double>(s.scan->sum_points) / static_cast<double>(s.count),
                          s.scan->point_times ? "each with its time" : "without times");
  if (!s.camera) return text;
  const CameraInspection& c = *s.camera;
  text += lead + format(
                     "%d x %d, fx %.1f fy %.1f cx %.1f cy %.1f, distortion %s, %llu inside of "
                     "the log, %llu in files",
                     c.width, c.height, c.fx, c.fy, c.cx, c.cy, c.distortion.c_str(),
                     static_cast<unsigned long long>(c.embedded),
                     static_cast<unsigned long long>(c.external));
  if (c.external_missing > 0)
    text += format(" (%llu missing)", static_cast<unsigned long long>(c.external_missing));
  return text + "\n";
}

std::string tagRow(const SurveyedTag& tag) {
  return format("%6d %6d %7.0f px %7.0f px", tag.id, tag.sightings, tag.min_edge_px,
                tag.max_edge_px) +
         (tag.measured_size_m
              ? format("   %.3f m (%d points)\n", *tag.measured_size_m, tag.size_points)
              : "   -\n");
}

/// Ascending ids as "1-4, 7".
std::string idRanges(const std::vector<SurveyedTag>& tags) {
  std::string text;
  for (std::size_t first = 0, last = 0; first < tags.size(); first = ++last) {
    while (last + 1 < tags.size() && tags[last + 1].id == tags[last].id + 1) ++last;
    text += (text.empty() ? "" : ", ") + std::to_string(tags[first].id);
    if (last > first) text += (last > first + 1 ? "-" : ", ") + std::to_string(tags[last].id);
  }
  return text;
}

/// What all of them have in common, in one line.
std::string tagsTogether(const std::vector<SurveyedTag>& tags) {
  int sightings = 0, measured = 0;
  double smallest_px = tags.front().min_edge_px, largest_px = 0.0;
  double smallest_m = 1e9, largest_m = 0.0;
  for (const SurveyedTag& tag : tags) {
    sightings += tag.sightings;
    smallest_px = std::min(smallest_px, tag.min_edge_px);
    largest_px = std::max(largest_px, tag.max_edge_px);
    if (!tag.measured_size_m) continue;
    ++measured;
    smallest_m = std::min(smallest_m, *tag.measured_size_m);
    largest_m = std::max(largest_m, *tag.measured_size_m);
  }
  std::string text = format("%zu tags, seen %d times, edges of %.0f to %.0f px, ", tags.size(),
                            sightings, smallest_px, largest_px);
  text += measured > 0 ? format("%d measured with %.3f to %.3f m", measured, smallest_m, largest_m)
                       : std::string("none measured");
  return text + ": ids " + idRanges(tags) + "\n";
}

std::string tagsText(const Inspection& log) {
  constexpr std::size_t kMostRows = 12;
  if (log.images_searched == 0) return {};
  std::string text = format("\nTags seen in %llu of the images\n",
                            static_cast<unsigned long long>(log.images_searched));
  if (log.tags.size() > kMostRows) return text + tagsTogether(log.tags);
  if (!log.tags.empty()) text += "    id   seen   smallest    largest   measured size\n";
  for (const SurveyedTag& tag : log.tags) text += tagRow(tag);
  return text;
}

std::string findingsText(const Inspection& log) {
  std::string text = "\n";
  for (const Finding& f : log.findings) {
    text += format("%-8s ", severityText(f.severity)) + f.what + "\n";
    if (!f.fix.empty()) text += "         -> " + f.fix + "\n";
    if (!f.commands.empty()) text += f.commands + "\n";
  }
  if (log.findings.empty()) text += "No problems found.\n";
  return text;
}

}  // namespace

std::string inspectionText(const Inspection& log) {
  std::string text =
      log.rawlog.string() + ": " +
      format("%.1f MB, %s, %s, %llu objects", static_cast<double>(log.file_bytes) / 1e6,
             log.compressed ? "compressed" : "not compressed",
             log.actions_and_frames ? "actions and sensory frames" : "observations",
             static_cast<unsigned long long>(log.objects));
  if (log.first)
    text += format(", %.1f s from %s", secondsBetween(*log.first, *log.last),
                   log.first->text().c_str());
  if (clockCount(log) > 1) text += format(", stamps of %zu clocks", clockCount(log));
  const Widths w = widths(log);
  text += "\n\n" + format("%-*s %-*s %-10s %8s %9s %9s %5s %8s %6s\n", w.label, "Sensor",
                          w.class_name, "Class", "Use", "Count", "Rate [Hz]", "Length[s]", "Gaps",
                          "Max [s]", "Jumps");
  for (const SensorInspection& s : log.sensors) text += sensorRow(s, w);
  for (const auto& [name, count] : log.other_objects)
    text += format("%-*s %-*s %-10s %8llu\n", w.label, "-", w.class_name, name.c_str(),
                   name == "CActionCollection" ? "odometry" : "not used",
                   static_cast<unsigned long long>(count));
  text += "\n";
  for (const SensorInspection& s : log.sensors) text += sensorDetails(s, w);
  text += tagsText(log) + findingsText(log) + "\n";
  text += log.runnable() ? format("dynemo-slam can run it: %llu frames.\n",
                                  static_cast<unsigned long long>(log.frames))
                         : std::string("dynemo-slam cannot run it as it is.\n");
  return text;
}

}  // namespace dynemo
