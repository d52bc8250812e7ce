// Surfaces from points that single scan lines leave behind while the sensor moves.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "dynemo/odometry/cell_index.h"

namespace dynemo {

/// Points of scan lines too far apart for a normal within one sweep, as a sensor of few rings has
/// them on the floor. Lines of several sweeps lie closer: where they cover an area, they show the
/// surface.
class ScanLinePoints {
 public:
  /// Lines of one sweep are told apart by their elevation, those of different sweeps always.
  void beginSweep() { ++sweep_; }
  /// Keeps the point unless one is nearer than the spacing, and returns the unit normal, of either
  /// sign, of the plane through it and its neighbours of all sweeps; empty as long as they are few,
  /// not flat or on less than three lines. `elevation_rad` is that of the ray in the sensor's
  /// frame.
  std::optional<Eigen::Vector3f> add(const Eigen::Vector3f& point, float elevation_rad);

  /// Forgets the cells whose centre is farther than radius_m from `center`.
  void removeFartherThan(const Eigen::Vector3f& center, double radius_m);
  void clear();

 private:
  struct LinePoint {
    Eigen::Vector3f p;
    std::uint32_t sweep;
    float elevation_rad;
  };
  struct Cell {
    CellCoordinates coordinates;
    std::vector<LinePoint> points;
  };

  void gather(const CellCoordinates& home, const Eigen::Vector3f& point);

  bool onThreeLines();
  /// Of the plane through the neighbours.
  std::optional<Eigen::Vector3f> normalOfNeighbors();
  /// Whether the neighbours cover an area of the plane that u and v span, and not just two lines.
  bool coverAnArea(const Eigen::Vector3f& u, const Eigen::Vector3f& v);

  CellIndex index_;
  std::vector<Cell> cells_;
  std::vector<LinePoint> neighbors_;
  std::vector<Eigen::Vector3f> fitted_;  ///< the neighbours' points
  std::vector<float> along_;             ///< their places in one direction, in order
  std::uint32_t sweep_ = 0;
};

}  // namespace dynemo
