#include "dynemo/query/session_difference.h"

#include <gtest/gtest.h>

#include <map>

#include "rooms.h"

namespace dynemo::test {
namespace {

const Pose3 T_world_mapB = Pose3::fromYawPitchRoll(5.0, -2.0, 0.1, 2.0, 0.01, -0.02);

Pose3 object(int id) { return Pose3::fromYawPitchRoll(id, 0.7 * id * id, 0.25, 0.9 * id, 0, 0); }

/// Objects 1–4 stand where they stood; 5 and 6 moved, together, by the same step; 7 is in A only
/// and 8 in B only.
Session sessionA() {
  SessionBuilder a;
  a.keyframe(0.0);
  for (const int id : {1, 2, 3, 4, 5, 6, 7}) a.see(id, id, object(id));
  return a.session;
}

Session sessionB() {
  SessionBuilder b(T_world_mapB);
  b.keyframe(0.0);
  for (const int id : {1, 2, 3, 4, 8}) b.see(id, id, object(id));
  for (const int id : {5, 6}) b.see(id, id, Pose3::translation(1.0, 0.0, 0.0) * object(id));
  return b.session;
}

std::map<std::int64_t, ObjectDifference> byId(const SessionDifference& d) {
  std::map<std::int64_t, ObjectDifference> map;
  for (const auto& o : d.objects) map[o.entity.value] = o;
  return map;
}

TEST(SessionDifference, AlignsByWhatDidNotMove) {
  const auto found = difference(sessionA(), sessionB());
  ASSERT_TRUE(found) << found.error();
  EXPECT_LT(local(T_world_mapB.inverse(), found->T_mapB_mapA).norm(), 1e-9);
  EXPECT_EQ(found->agreeing, (std::vector<EntityId>{{1}, {2}, {3}, {4}}));
  EXPECT_LT(found->rms_m, 1e-9);
}

TEST(SessionDifference, NamesEveryChange) {
  const auto found = difference(sessionA(), sessionB());
  ASSERT_TRUE(found) << found.error();
  auto objects = byId(*found);
  ASSERT_EQ(objects.size(), 8u);
  for (const int id : {1, 2, 3, 4}) EXPECT_EQ(objects[id].change, ObjectChange::kUnchanged) << id;
  for (const int id : {5, 6}) {
    EXPECT_EQ(objects[id].change, ObjectChange::kMoved) << id;
    const double moved_m = (objects[id].T_mapB_entityA->t - objects[id].T_mapB_entityB->t).norm();
    EXPECT_NEAR(moved_m, 1.0, 1e-9);
  }
  EXPECT_EQ(objects[7].change, ObjectChange::kDisappeared);
  EXPECT_FALSE(objects[7].T_mapB_entityB);
  EXPECT_EQ(objects[8].change, ObjectChange::kAppeared);
  EXPECT_FALSE(objects[8].T_mapB_entityA);
  EXPECT_EQ(objects[8].certainty, 0.5);  // no scan looked
}

TEST(SessionDifference, ReversedIsTheInverse) {
  const auto there = difference(sessionA(), sessionB()), back = difference(sessionB(), sessionA());
  ASSERT_TRUE(there && back);
  EXPECT_LT(local(Pose3(), there->T_mapB_mapA * back->T_mapB_mapA).norm(), 1e-9);
}

TEST(SessionDifference, AnObjectOfBIsComparedWithWhereBFoundItFirst) {
  // Object 1 is carried away during B: it still helps to align, and its end is different.
  SessionBuilder b(T_world_mapB);
  b.keyframe(0.0);
  for (const int id : {1, 2}) b.see(id, id, object(id));
  b.see(1, 60.0, object(9), true);
  const auto found = difference(sessionA(), b.session);
  ASSERT_TRUE(found) << found.error();
  EXPECT_EQ(found->agreeing, (std::vector<EntityId>{{1}, {2}}));
  EXPECT_EQ(byId(*found)[1].change, ObjectChange::kMoved);
}

TEST(SessionDifference, AlignsByAllPlacesThatAgree) {
  // Objects 3 to 5 are carried away during both sessions, to the same places.
  const auto session = [](const Pose3& T_world_map) {
    SessionBuilder builder(T_world_map);
    builder.keyframe(0.0);
    for (const int id : {1, 2, 3, 4, 5}) builder.see(id, id, object(id));
    for (const int id : {3, 4, 5}) builder.see(id, 60.0 + id, object(id + 4), true);
    return builder.session;
  };
  const auto found = difference(session({}), session(T_world_mapB));
  ASSERT_TRUE(found) << found.error();
  EXPECT_EQ(found->agreeing.size(), 5u);
  EXPECT_EQ(found->common, 5u);
  for (const auto& o : found->objects) EXPECT_EQ(o.change, ObjectChange::kUnchanged) << o.name;
}

TEST(SessionDifference, SaysWhyThereIsNoAlignment) {
  SessionBuilder b;
  b.keyframe(0.0);
  b.see(1, 1.0, object(1));
  b.see(2, 2.0, object(9));
  const auto found = difference(sessionA(), b.session);
  ASSERT_FALSE(found);
  EXPECT_NE(found.error().find("of 2 objects in common, 1 agree"), std::string::npos);
  EXPECT_FALSE(difference(Session(), Session()));
}

TEST(SessionDifference, ScansTellWhetherAPlaceIsReallyEmpty) {
  const auto seen = [](const Vector3& box, bool is_there) {
    SessionBuilder s;
    s.scan(0.0, is_there ? std::vector<Vector3>{box} : std::vector<Vector3>{});
    for (const int id : {1, 2}) s.see(id, id, object(id));
    if (is_there) s.see(9, 3.0, Pose3::translation(box));
    return s.session;
  };
  const Vector3 box(3.0, 0.0, 0.0);
  const Session with = seen(box, true), without = seen(box, false);
  const auto gone = difference(with, without), come = difference(without, with);
  ASSERT_TRUE(gone && come);
  EXPECT_EQ(byId(*gone)[9].change, ObjectChange::kDisappeared);
  EXPECT_GT(byId(*gone)[9].certainty, 0.9);
  EXPECT_EQ(byId(*come)[9].change, ObjectChange::kAppeared);
  EXPECT_GT(byId(*come)[9].certainty, 0.9);
}

}  // namespace
}  // namespace dynemo::test
