#include "dynemo/life/life_params.h"

namespace dynemo {

void fields(FieldVisitor& v, LifeParams& p) {
  v.flag("bounded", p.bounded,
         "Keyframes leave the graph where newer and older ones cover the same area, so that time "
         "and memory stay level on floors that are visited again and again");
  v.integer("window", p.window, "So many of the newest keyframes always stay",
            Range::between(2, 1e6));
  v.number("cell_m", p.cell_m, "Side of the squares of the floor in which keyframes are counted",
           Range::positive());
  v.integer("headings", p.headings, "Headings that are counted apart", Range::between(1, 360));
  v.integer("per_cell", p.per_cell, "Older keyframes that stay per square and heading",
            Range::between(1, 1e6));
  v.integer("batch", p.batch,
            "They leave so many at a time: each is then placed with its neighbours around it",
            Range::between(1, 1e6));
  v.number("weakest_sigma_m", p.weakest_sigma_m,
           "What a keyframe that leaves says of two nodes is forgotten where it is less certain",
           Range::positive());
  v.angle("weakest_sigma_deg", p.weakest_sigma_rad, "The same of their rotation",
          Range::positive());
}

}  // namespace dynemo
