#include <cmath>
#include <cstdio>
#include <numbers>

#include "answers.h"
#include "text_table.h"

namespace dynemo {
namespace {

std::string fixed(double value, int digits) {
  char buffer[64];
  std::snprintf(buffer, sizeof(buffer), "%.*f", digits, value);
  const std::string text = buffer;
  // No minus before a zero.
  return text.find_first_not_of("-0.") == std::string::npos && text[0] == '-' ? text.substr(1)
                                                                              : text;
}

double degrees(double rad) { return rad * 180.0 / std::numbers::pi; }

double yaw(const Pose3& T) { return std::atan2(T.R(1, 0), T.R(0, 0)); }

std::string after(Stamp begin, Stamp stamp) {
  const std::string text = fixed(secondsBetween(begin, stamp), 3);
  return text[0] == '-' ? text : "+" + text;
}

std::string afterOrDash(Stamp begin, const std::optional<Stamp>& stamp) {
  return stamp ? after(begin, *stamp) : "-";
}

std::string percent(double share) { return fixed(100.0 * share, 1); }

TableRow position(const Pose3& T) {
  return {fixed(T.t.x(), 3), fixed(T.t.y(), 3), fixed(T.t.z(), 3)};
}

void add(TableRow& row, const TableRow& more) { row.insert(row.end(), more.begin(), more.end()); }

std::string sigmas(const Matrix6& covariance, int first, double scale, int digits) {
  std::string text;
  for (int i = first; i < first + 3; ++i)
    text += (i == first ? "" : " ") + fixed(scale * std::sqrt(covariance(i, i)), digits);
  return text;
}

}  // namespace

std::string whereText(const Whereabouts& w, Stamp at, Stamp begin) {
  const Eigen::Quaterniond q = w.T_map_entity.quaternion();
  std::string text = "entity      " + w.name + " (" + semanticClassName(w.semantic_class) +
                     ", id " + std::to_string(w.entity.value) + ")\n";
  text += "at          " + at.text() + " (" + after(begin, at) + " s)\n";
  const Vector3& t = w.T_map_entity.t;
  text += "position    " + fixed(t.x(), 3) + ' ' + fixed(t.y(), 3) + ' ' + fixed(t.z(), 3) + " m\n";
  text += "quaternion  " + fixed(q.x(), 6) + ' ' + fixed(q.y(), 6) + ' ' + fixed(q.z(), 6) + ' ' +
          fixed(q.w(), 6) + " (yaw " + fixed(degrees(yaw(w.T_map_entity)), 1) + " deg)\n";
  text += "sigma       ";
  text += w.covariance
              ? sigmas(*w.covariance, 0, 1.0, 4) + " m, " +
                    sigmas(*w.covariance, 3, 180.0 / std::numbers::pi, 2) + " deg (own axes)\n"
              : "unknown\n";
  const auto seen = [&](const std::optional<Stamp>& stamp) {
    return stamp ? stamp->text() + " (" + after(begin, *stamp) + " s)\n" : std::string("never\n");
  };
  text += "last seen   " + seen(w.last_seen);
  text += "next seen   " + seen(w.next_seen);
  text += "still there " + percent(w.presence) + " %\n";
  if (!w.alternative) return text;
  const Vector3& p = w.alternative->T_map_entity.t;
  text += "or at       " + fixed(p.x(), 3) + ' ' + fixed(p.y(), 3) + ' ' + fixed(p.z(), 3) +
          " m, " + percent(w.alternative->presence) + " %\n";
  return text + "on its way  " + percent(w.carried()) + " %\n";
}

std::string movedText(const std::vector<Move>& moves, Stamp begin) {
  if (moves.empty()) return "no object moved\n";
  std::vector<TableRow> rows;
  for (const Move& m : moves) {
    TableRow row = {std::to_string(m.entity.value), m.name};
    add(row, position(m.T_map_before));
    add(row, position(m.T_map_after));
    add(row, {fixed(m.distance(), 3),
              fixed(degrees(rotationAngle(m.T_map_before.inverse() * m.T_map_after)), 1),
              after(begin, m.last_before), after(begin, m.first_after), percent(m.probability)});
    rows.push_back(row);
  }
  return textTable({"id", "name", "from x", "y", "z", "to x", "y", "z", "moved [m]", "turned [deg]",
                    "after [s]", "before [s]", "then [%]"},
                   rows);
}

std::string nearText(const std::vector<Whereabouts>& found, const Vector3& p_map, Stamp begin) {
  if (found.empty()) return "nothing\n";
  std::vector<TableRow> rows;
  for (const Whereabouts& w : found) {
    TableRow row = {std::to_string(w.entity.value), w.name, semanticClassName(w.semantic_class),
                    fixed((w.T_map_entity.t - p_map).norm(), 3)};
    add(row, position(w.T_map_entity));
    add(row, {afterOrDash(begin, w.last_seen), percent(w.presence)});
    rows.push_back(row);
  }
  return textTable(
      {"id", "name", "class", "distance [m]", "x", "y", "z", "last seen [s]", "still there [%]"},
      rows);
}

std::string trackText(const std::vector<Sighting>& track, Stamp begin) {
  std::vector<TableRow> rows;
  for (const Sighting& s : track) {
    TableRow row = {s.stamp.text(), after(begin, s.stamp)};
    add(row, position(s.T_map_entity));
    row.push_back(fixed(degrees(yaw(s.T_map_entity)), 1));
    row.push_back(s.covariance ? fixed(std::sqrt(s.covariance->topLeftCorner<3, 3>().trace()), 4)
                               : "-");
    row.push_back(s.moved ? "moved" : "");
    rows.push_back(row);
  }
  return textTable({"time", "after [s]", "x", "y", "z", "yaw [deg]", "sigma [m]", ""}, rows);
}

std::string entitiesText(const std::vector<Whereabouts>& all, Stamp begin) {
  if (all.empty()) return "nothing\n";
  std::vector<TableRow> rows;
  for (const Whereabouts& w : all) {
    TableRow row = {std::to_string(w.entity.value), w.name, semanticClassName(w.semantic_class)};
    add(row, position(w.T_map_entity));
    add(row, {afterOrDash(begin, w.last_seen), percent(w.presence)});
    rows.push_back(row);
  }
  return textTable({"id", "name", "class", "x", "y", "z", "last seen [s]", "still there [%]"},
                   rows);
}

std::string differenceText(const SessionDifference& difference) {
  const Pose3& T = difference.T_mapB_mapA;
  std::string text = "aligned by " + std::to_string(difference.agreeing.size()) + " of " +
                     std::to_string(difference.common) + " objects in common, rms " +
                     fixed(difference.rms_m, 3) + " m; map of A in B: " + fixed(T.t.x(), 3) + ' ' +
                     fixed(T.t.y(), 3) + ' ' + fixed(T.t.z(), 3) + " m, yaw " +
                     fixed(degrees(yaw(T)), 2) + " deg\n";
  std::vector<TableRow> rows;
  const TableRow nowhere = {"-", "-", "-"};
  for (const ObjectDifference& d : difference.objects) {
    TableRow row = {std::to_string(d.entity.value), d.name, changeName(d.change)};
    add(row, d.T_mapB_entityA ? position(*d.T_mapB_entityA) : nowhere);
    add(row, d.T_mapB_entityB ? position(*d.T_mapB_entityB) : nowhere);
    const bool both = d.T_mapB_entityA && d.T_mapB_entityB;
    row.push_back(both ? fixed((d.T_mapB_entityA->t - d.T_mapB_entityB->t).norm(), 3) : "-");
    row.push_back(percent(d.certainty));
    rows.push_back(row);
  }
  return text + textTable({"id", "name", "change", "A: x", "y", "z", "B: x", "y", "z", "moved [m]",
                           "sure [%]"},
                          rows);
}

}  // namespace dynemo
