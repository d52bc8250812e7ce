// How long keyframes stay in the graph of a robot that keeps going over the same floors.
#pragma once

#include "dynemo/core/fields.h"

namespace dynemo {

struct LifeParams {
  /// Whether keyframes leave the graph at all.
  bool bounded = false;
  /// So many of the newest keyframes always stay.
  int window = 50;
  /// Of the older ones, so many stay per square of the floor and heading.
  double cell_m = 1.5;
  int headings = 8;
  int per_cell = 2;
  /// They leave so many at a time: each is then placed with all its neighbours around it.
  int batch = 20;
  /// What a keyframe that leaves says of two nodes is forgotten where it is less certain than this.
  double weakest_sigma_m = 0.15;
  double weakest_sigma_rad = 0.10471975511965977;  // 6°
};
void fields(FieldVisitor& v, LifeParams& p);

}  // namespace dynemo
