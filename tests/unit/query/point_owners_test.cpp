// Whose the points of scans are, in a room whose truth is known.
#include "dynemo/query/point_owners.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "rooms.h"

namespace dynemo::test {
namespace {

using Box = Eigen::AlignedBox3d;

Box boxAt(const Vector3& middle, const Vector3& size) {
  return {middle - 0.5 * size, middle + 0.5 * size};
}

/// A room of 8 m × 6 m × 2.5 m with a table leg and, where a test puts them, movable boxes; the
/// robot stands at different places in it.
class Room {
 public:
  static constexpr double kLidar_m = 0.6;

  explicit Room(bool mapped_floor = true) {
    if (!mapped_floor) return;
    auto floor = std::make_shared<CNodeFloor>();
    floor->id = session.graph.nextNodeId();
    floor->extendArea({Vector2(0, 0), Vector2(8, 6)});
    session.graph.apply(GraphDelta{{floor}, {}, {}});
  }

  /// A scan in which the boxes of `things` stand, too; `hit_` tells what each point is on.
  const CNodeKeyframe& scan(double seconds, const Vector2& at_m, const std::vector<Box>& things) {
    auto node = std::make_shared<CNodeKeyframe>();
    node->id = session.graph.nextNodeId();
    node->stamp = at(seconds);
    node->T_map_node = node->T_odom_base = Pose3::translation(at_m.x(), at_m.y(), 0.0);
    auto scan = std::make_shared<Scan>();
    scan->T_base_lidar = Pose3::translation(0.0, 0.0, kLidar_m);
    const Vector3 from(at_m.x(), at_m.y(), kLidar_m);
    for (double elevation = -24.0; elevation <= 24.0; elevation += 2.0) {
      for (double azimuth = -180.0; azimuth < 180.0; azimuth += 1.0) {
        const auto [end, thing] = cast(from, direction(azimuth, elevation), things);
        scan->cloud.points.push_back((end - from).cast<float>());
        hit_[node->id].push_back(thing);
      }
    }
    node->scan = scan;
    session.graph.apply(GraphDelta{{node}, {}, {}});
    return session.graph.getNode<CNodeKeyframe>(node->id);
  }

  /// The entity is observed in a scan; its fragment is what is on one of the things.
  void observe(const CNodeKeyframe& keyframe, std::int64_t id, const Pose3& T_map_entity, int thing,
               SemanticClass semantic_class, bool moved = false) {
    auto node = std::make_shared<CNodeEntity>();
    node->id = session.graph.nextNodeId();
    node->entity = {id};
    node->semantic_class = semantic_class;
    node->keyframe = keyframe.id;
    node->stamp = keyframe.stamp;
    node->T_map_node = T_map_entity;
    node->moved = moved;
    const auto& hit = hit_.at(keyframe.id);
    for (std::uint32_t i = 0; i < hit.size(); ++i)
      if (hit[i] == thing) node->fragment.push_back(i);
    session.graph.apply(GraphDelta{{node}, {}, {}});
  }

  PointOwners owners(const StructureParams& params = {}) const {
    return {session.graph, session.entity_covariances, params};
  }

  /// How many points of a scan are on the thing, and how many of those have the owner.
  struct Count {
    int all = 0, owned = 0;
    double share() const { return all ? static_cast<double>(owned) / all : 0.0; }
  };
  Count count(const PointOwners& owners, const CNodeKeyframe& keyframe, int thing,
              std::int32_t owner) const {
    Count n;
    const auto& hit = hit_.at(keyframe.id);
    for (std::size_t i = 0; i < hit.size(); ++i) {
      if (hit[i] != thing) continue;
      ++n.all;
      n.owned += owners.of(keyframe).owner[i] == owner;
    }
    return n;
  }
  /// The same with the points that an entity has.
  Count countOf(const PointOwners& owners, const CNodeKeyframe& keyframe, int thing,
                std::int64_t entity) const {
    Count n;
    const auto& hit = hit_.at(keyframe.id);
    for (std::size_t i = 0; i < hit.size(); ++i) {
      if (hit[i] != thing) continue;
      ++n.all;
      const PlacedEntity* owner = owners.of(keyframe).entity(i);
      n.owned += owner && owner->entity == EntityId{entity};
    }
    return n;
  }

  /// What belongs to the room itself.
  static constexpr int kShell = -1, kLeg = -2;
  Session session;

 private:
  static Vector3 direction(double azimuth_deg, double elevation_deg) {
    constexpr double kDegree = std::numbers::pi / 180.0;
    const double c = std::cos(elevation_deg * kDegree);
    return {c * std::cos(azimuth_deg * kDegree), c * std::sin(azimuth_deg * kDegree),
            std::sin(elevation_deg * kDegree)};
  }

  static double enters(const Vector3& from, const Vector3& along, const Box& box) {
    double in = 0.0, out = 1e9;
    for (int axis = 0; axis < 3; ++axis) {
      const double a = (box.min()[axis] - from[axis]) / along[axis];
      const double b = (box.max()[axis] - from[axis]) / along[axis];
      in = std::max(in, std::min(a, b));
      out = std::min(out, std::max(a, b));
    }
    return in < out ? in : 1e9;
  }

  static std::pair<Vector3, int> cast(const Vector3& from, const Vector3& along,
                                      const std::vector<Box>& things) {
    double range_m = 1e9;
    for (int axis = 0; axis < 3; ++axis) {
      const double limit = along[axis] > 0 ? Vector3(8.0, 6.0, 2.5)[axis] : 0.0;
      if (std::abs(along[axis]) > 1e-9)
        range_m = std::min(range_m, (limit - from[axis]) / along[axis]);
    }
    int thing = kShell;
    const auto meet = [&](const Box& box, int index) {
      const double r = enters(from, along, box);
      if (r < range_m) {
        range_m = r;
        thing = index;
      }
    };
    meet(boxAt({6.0, 1.0, 0.37}, {0.06, 0.06, 0.74}), kLeg);
    for (std::size_t i = 0; i < things.size(); ++i) meet(things[i], static_cast<int>(i));
    return {from + range_m * along, thing};
  }

  std::map<NodeId, std::vector<int>> hit_;
};

const Vector2 kPlaces[] = {{1.5, 2.0}, {2.5, 3.0}, {2.0, 4.0}, {3.0, 2.0}, {1.5, 3.5}};
Vector2 placeOf(int i) { return kPlaces[i % 5]; }

/// Somebody whom no camera ever sees walks along y = 3 m; the robot looks on from several places.
std::vector<const CNodeKeyframe*> walk(Room& room) {
  std::vector<const CNodeKeyframe*> scans;
  for (int i = 0; i < 12; ++i) {
    const Box person = boxAt({4.0 + 0.3 * i, 3.0, 0.85}, {0.3, 0.5, 1.7});
    scans.push_back(&room.scan(i, placeOf(i), {person}));
  }
  return scans;
}

TEST(PointOwners, WhatOthersSeeThroughIsPassing) {
  Room room;
  const auto scans = walk(room);
  const PointOwners owners = room.owners();
  Room::Count person, shell, leg;
  for (const CNodeKeyframe* scan : scans) {
    const auto add = [&](Room::Count& sum, int thing, std::int32_t owner) {
      const Room::Count n = room.count(owners, *scan, thing, owner);
      sum.all += n.all;
      sum.owned += n.owned;
    };
    add(person, 0, ScanOwners::kPassing);
    add(shell, Room::kShell, ScanOwners::kStructure);
    add(leg, Room::kLeg, ScanOwners::kStructure);
  }
  EXPECT_GT(person.all, 500);
  // Within the tolerance of the floor, the soles of the feet are floor.
  EXPECT_GT(person.share(), 0.9);
  EXPECT_GT(shell.all, 50'000);
  EXPECT_GT(shell.share(), 0.9999);
  EXPECT_GT(leg.all, 30);
  EXPECT_EQ(leg.owned, leg.all);
}

TEST(PointOwners, WallsThatNoPlaneMapsStay) {
  // Neither floor nor planes are in the graph: rays along the floor alone say nothing against it.
  Room room(false);
  const auto scans = walk(room);
  const PointOwners owners = room.owners();
  for (const CNodeKeyframe* scan : scans)
    EXPECT_GT(room.count(owners, *scan, Room::kShell, ScanOwners::kStructure).share(), 0.998);
}

TEST(PointOwners, NothingPassesWhenScansAreNotAsked) {
  Room room;
  const auto scans = walk(room);
  StructureParams params;
  params.seen_through = false;
  const PointOwners owners = room.owners(params);
  for (const CNodeKeyframe* scan : scans)
    EXPECT_EQ(room.count(owners, *scan, 0, ScanOwners::kStructure).share(), 1.0);
}

TEST(PointOwners, WhatIsGoneIsPassingAndWhatCameIsStructure) {
  Room room;
  const Box chair = boxAt({5.0, 4.0, 0.4}, {0.5, 0.5, 0.8});
  const Box shelf = boxAt({5.0, 1.5, 0.8}, {0.5, 0.3, 1.6});
  std::vector<const CNodeKeyframe*> before, after;
  for (int i = 0; i < 8; ++i) before.push_back(&room.scan(i, placeOf(i), {chair}));
  for (int i = 8; i < 16; ++i) after.push_back(&room.scan(i, placeOf(i), {shelf}));
  const PointOwners owners = room.owners();
  for (const CNodeKeyframe* scan : before)
    EXPECT_GT(room.count(owners, *scan, 0, ScanOwners::kPassing).share(), 0.85);
  for (const CNodeKeyframe* scan : after)
    EXPECT_EQ(room.count(owners, *scan, 0, ScanOwners::kStructure).share(), 1.0);
}

class Volumes : public testing::Test {
 protected:
  Volumes() { params_.seen_through = false; }

  StructureParams params_;
  const Vector3 size_{0.5, 0.5, 0.5};
  const Vector3 old_{4.0, 2.0, 0.25}, other_{4.0, 4.5, 0.25};
};

TEST_F(Volumes, AnObjectThatIsNotObservedStillHasItsPoints) {
  Room room;
  const auto& unseen = room.scan(0, placeOf(0), {boxAt(old_, size_)});
  const auto& seen = room.scan(1, placeOf(1), {boxAt(old_, size_)});
  room.observe(seen, 7, Pose3::translation(old_.x(), old_.y(), old_.z()), 0,
               SemanticClass::kObject);
  const auto& between = room.scan(2, placeOf(2), {boxAt(old_, size_)});
  // Carried away unseen, and something else stands there when it is found.
  const auto& found = room.scan(3, placeOf(3), {boxAt(other_, size_), boxAt(old_, size_)});
  room.observe(found, 7, Pose3::translation(other_.x(), other_.y(), other_.z()), 0,
               SemanticClass::kObject, true);
  const PointOwners owners = room.owners(params_);
  for (const CNodeKeyframe* scan : {&unseen, &seen, &between, &found}) {
    const auto count = room.countOf(owners, *scan, 0, 7);
    EXPECT_GT(count.all, 20);
    // The lowest points are the floor's.
    EXPECT_GT(count.share(), 0.8);
  }
  EXPECT_EQ(room.countOf(owners, found, 1, 7).owned, 0);
  for (const CNodeKeyframe* scan : {&unseen, &seen, &between, &found})
    EXPECT_EQ(room.countOf(owners, *scan, Room::kShell, 7).owned, 0);
  params_.volumes = false;
  EXPECT_EQ(room.countOf(room.owners(params_), between, 0, 7).owned, 0);
}

TEST_F(Volumes, AnAgentIsWhereItWalksBetweenTwoObservations) {
  Room room;
  const Vector3 body(0.3, 0.5, 1.7);
  const auto person = [&](double x) { return boxAt({x, 3.0, 0.85}, body); };
  const auto pose = [](double x) { return Pose3::translation(x, 3.0, 0.85); };
  const auto& first = room.scan(0.0, placeOf(0), {person(4.0)});
  room.observe(first, 101, pose(4.0), 0, SemanticClass::kAgent);
  const auto& unseen = room.scan(0.5, placeOf(1), {person(4.4)});
  const auto& second = room.scan(1.0, placeOf(2), {person(4.8)});
  room.observe(second, 101, pose(4.8), 0, SemanticClass::kAgent);
  const auto& later = room.scan(8.0, placeOf(3), {person(4.8)});
  const PointOwners owners = room.owners(params_);
  EXPECT_GT(room.countOf(owners, unseen, 0, 101).share(), 0.9);
  EXPECT_EQ(room.countOf(owners, later, 0, 101).owned, 0);
  params_.agent_gap_s = 0.9;
  EXPECT_EQ(room.countOf(room.owners(params_), unseen, 0, 101).owned, 0);
}

TEST_F(Volumes, AFragmentThatHoldsWhatStandsBesideDoesNotCount) {
  Room room;
  const Box box = boxAt(old_, size_), shelf = boxAt({4.6, 2.0, 0.8}, {0.5, 0.5, 1.6});
  const Pose3 T = Pose3::translation(old_.x(), old_.y(), old_.z());
  const CNodeKeyframe* last = nullptr;
  for (int i = 0; i < 5; ++i) {
    last = &room.scan(i, placeOf(i), {box, shelf});
    room.observe(*last, 7, T, 0, SemanticClass::kObject);
  }
  // One fragment is of box and shelf.
  auto& polluted = const_cast<CNodeEntity&>(*room.session.graph.tracks().at({7}).back());
  for (std::uint32_t i = 0; i < last->scan->cloud.size(); ++i) {
    const Vector3 p =
        last->T_map_base() * last->scan->T_base_lidar * last->scan->cloud.points[i].cast<double>();
    if (shelf.exteriorDistance(p) < 1e-3) polluted.fragment.push_back(i);
  }
  const PointOwners owners = room.owners(params_);
  EXPECT_GT(room.countOf(owners, *last, 0, 7).share(), 0.8);
  EXPECT_GT(room.count(owners, *last, 1, ScanOwners::kStructure).share(), 0.9);
}

}  // namespace
}  // namespace dynemo::test
