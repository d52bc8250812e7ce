#pragma once

#include "dynemo/core/fields.h"

namespace dynemo {

/// What is believed of entities while nobody looks at them.
struct QueryParams {
  /// Objects: how long one stays where it was put, as believed before any was seen moving [s].
  double object_residence_s = 3600.0;
  /// Of scans that look at a place: how often the place of an object that is there looks empty, and
  /// how often a place that was left looks occupied.
  double missed_probability = 0.02;
  double false_probability = 0.2;
  /// How often an object is missed is learnt from the scans of the time in which it was known to be
  /// there; missed_probability weighs as much as so many of them.
  double missed_prior_looks = 5.0;
  /// A scan says something about a place only with so many rays through it, and at most so far
  /// away.
  int min_rays = 8;
  double max_range_m = 12.0;

  /// Agents: root mean square of the velocity along each horizontal axis, and how long they keep
  /// it.
  double agent_speed_mps = 0.8;
  double agent_persistence_s = 3.0;
  /// An agent is "still there" within this distance of where it is said to be.
  double agent_near_m = 0.5;

  /// Displacements between the final estimates that are smaller than both are not called a move,
  double min_move_m = 0.05;
  double min_move_rad = 0.06;
  /// nor those that their covariances explain: up to this squared Mahalanobis distance (chi-squared
  /// of 6 degrees of freedom at 99 %),
  double noise_mahalanobis2 = 16.8;
  /// nor those up to here that fewer sightings show than its place before and after, to which it
  /// came back, or a single one in the beginning or the end: a tag seen aslant may be that wrong.
  double max_slip_m = 0.3;
  /// How fast objects are carried from one place to another, at most.
  double object_carry_mps = 2.0;
  /// Moves of one object that follow each other within this time are one move, seen as it happened.
  double same_move_s = 5.0;

  bool operator==(const QueryParams&) const = default;
};
void fields(FieldVisitor& v, QueryParams& p);

}  // namespace dynemo
