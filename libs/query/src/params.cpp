#include "dynemo/query/query_params.h"
#include "dynemo/query/session_difference.h"
#include "dynemo/query/structure_params.h"

namespace dynemo {

void fields(FieldVisitor& v, QueryParams& p) {
  v.number("object_residence_s", p.object_residence_s,
           "How long an object stays where it was put, before any was seen moving",
           Range::positive());
  v.number("missed_probability", p.missed_probability,
           "How often the place of an object that is there looks empty in a scan",
           Range::between(0.001, 0.5));
  v.number("false_probability", p.false_probability,
           "How often a place that an object has left looks occupied in a scan",
           Range::between(0.001, 0.5));
  v.number("missed_prior_looks", p.missed_prior_looks,
           "How often an object is missed is learnt while it is known to be there; this many scans "
           "weigh as much as missed_probability",
           Range::positive());
  v.integer("min_rays", p.min_rays, "Rays through a place that a scan takes to say anything of it",
            Range::between(1, 100000));
  v.number("max_range_m", p.max_range_m, "Scans from further away say nothing of a place",
           Range::positive());
  v.number("agent_speed_mps", p.agent_speed_mps,
           "Agents: root mean square velocity along each horizontal axis", Range::positive());
  v.number("agent_persistence_s", p.agent_persistence_s, "Agents: how long they keep a velocity",
           Range::positive());
  v.number("agent_near_m", p.agent_near_m,
           "Agents: still there within this distance of where they are said to be",
           Range::positive());
  v.number("min_move_m", p.min_move_m, "Smaller displacements of an object are no move",
           Range::nonNegative());
  v.angle("min_move_deg", p.min_move_rad, "Smaller rotations of an object are no move",
          Range::nonNegative());
  v.number("noise_mahalanobis2", p.noise_mahalanobis2,
           "Displacements up to this squared Mahalanobis distance are no move",
           Range::nonNegative());
  v.number(
      "max_slip_m", p.max_slip_m,
      "Displacements up to this are no move when fewer sightings show them than its place before "
      "and after, or a single one in the beginning or the end",
      Range::nonNegative());
  v.number("object_carry_mps", p.object_carry_mps, "How fast objects are carried, at most",
           Range::positive());
  v.number("same_move_s", p.same_move_s, "Moves that follow each other this soon are one",
           Range::nonNegative());
}

void fields(FieldVisitor& v, StructureParams& p) {
  v.flag("volumes", p.volumes,
         "What is inside an entity, from all that was seen of it, is the entity's in every scan");
  v.number("margin_m", p.margin_m, "So much around what was seen of an entity is the entity's, too",
           Range::between(0.0, 1.0));
  v.number("agent_gap_s", p.agent_gap_s,
           "Agents are on the straight line between two observations at most so far apart in time",
           Range::nonNegative());
  v.number("surface_tolerance_m", p.surface_tolerance_m,
           "Points so near to a mapped floor, wall or ceiling are structure, whatever stands there",
           Range::between(0.0, 1.0));
  v.flag("seen_through", p.seen_through, "What other scans see through is no structure");
  v.number("voxel_m", p.voxel_m, "Size of the places that are judged as one",
           Range::between(0.02, 1.0));
  v.number("max_range_m", p.max_range_m, "Scans from further away say nothing of a place",
           Range::positive());
  v.integer("max_looks", p.max_looks,
            "So many scans at most look at a place, from viewpoints and at times that lie apart; "
            "four times as many where these do not tell",
            Range::between(8, 1000000));
  v.number("ray_radius_m", p.ray_radius_m,
           "A ray goes through a place when it passes its middle this closely",
           Range::between(0.001, 1.0));
  v.number("behind_m", p.behind_m, "and ends so far behind it", Range::between(0.01, 10.0));
  v.integer("min_through", p.min_through,
            "A place is no structure when at least so many scans see through it",
            Range::between(1, 1000));
  v.number("max_hit_share", p.max_hit_share,
           "and less than this share of the scans that look there see something",
           Range::between(0.0, 1.0));
  v.number("gone_probability", p.gone_probability,
           "or when, were it still there, the scans since it was last seen were this unlikely",
           Range::between(0.0, 0.5));
}

void fields(FieldVisitor& v, DifferenceParams& p) {
  v.number("max_distance_m", p.max_distance_m,
           "Objects that agree with an alignment to this distance did not move", Range::positive());
  v.angle("max_rotation_deg", p.max_rotation_rad, "and to this rotation", Range::positive());
  v.integer("min_agreeing", p.min_agreeing, "Objects that must agree on an alignment",
            Range::between(1, 100000));
  v.section("query", p.query, "What is believed of entities while nobody looks at them");
}

}  // namespace dynemo
