#include "dynemo/query/scene_query.h"

#include <gtest/gtest.h>

#include "rooms.h"

namespace dynemo::test {
namespace {

const Vector3 kA(3.0, 0.0, 0.0), kB(3.0, 1.0, 0.0);

Pose3 place(const Vector3& p) { return Pose3::translation(p); }

/// A box that is seen at A at 0 and 2 s and at B at 12 and 20 s, and the robot goes on until 30 s.
SessionBuilder movedBox() {
  SessionBuilder builder;
  builder.keyframe(0.0);
  builder.see(3, 0.0, place(kA), false, SemanticClass::kObject, "box 3");
  builder.see(3, 2.0, place(kA));
  builder.keyframe(12.0);
  builder.see(3, 12.0, place(kB), true);
  builder.see(3, 20.0, place(kB));
  builder.keyframe(30.0);
  return builder;
}

TEST(SceneQuery, KnowsItsTimesAndEntities) {
  const SessionBuilder builder = movedBox();
  const SceneQuery query(builder.session);
  EXPECT_EQ(query.begin(), at(0.0));
  EXPECT_EQ(query.end(), at(30.0));
  EXPECT_EQ(query.entities(), std::vector<EntityId>{EntityId{3}});
  EXPECT_EQ(query.track({3}).size(), 4u);
}

TEST(SceneQuery, FindsEntitiesByIdAndName) {
  SessionBuilder builder = movedBox();
  builder.see(4, 1.0, place(kB), false, SemanticClass::kObject, "chair");
  builder.see(5, 1.0, place(kB), false, SemanticClass::kObject, "chair");
  const SceneQuery query(builder.session);
  EXPECT_EQ(query.find("3").value(), EntityId{3});
  EXPECT_EQ(query.find("box 3").value(), EntityId{3});
  EXPECT_EQ(query.find("chair 4").value(), EntityId{4});
  EXPECT_NE(query.find("chair").error().find("several"), std::string::npos);
  EXPECT_NE(query.find("table").error().find("3 (box 3), 4 (chair 4)"), std::string::npos);
}

TEST(SceneQuery, AnObjectIsWhereItWasSeen) {
  const SessionBuilder builder = movedBox();
  const SceneQuery query(builder.session);
  const Whereabouts w = query.where({3}, at(1.0));
  EXPECT_EQ(w.T_map_entity.t, kA);
  EXPECT_EQ(w.presence, 1.0);
  EXPECT_EQ(w.last_seen, at(0.0));
  EXPECT_EQ(w.next_seen, at(2.0));
  ASSERT_TRUE(w.covariance);
  EXPECT_NEAR((*w.covariance)(0, 0), 1e-4, 1e-12);
}

/// One second for the metre from A to B.
QueryParams slowlyCarried() {
  QueryParams params;
  params.object_carry_mps = 1.0;
  return params;
}

TEST(SceneQuery, BetweenTwoPlacesTheNearerInTimeIsMoreProbable) {
  const SessionBuilder builder = movedBox();
  const SceneQuery query(builder.session, slowlyCarried());
  const Whereabouts early = query.where({3}, at(4.0)), late = query.where({3}, at(11.0));
  // It is carried for a second, some time of the ten.
  EXPECT_EQ(early.T_map_entity.t, kA);
  EXPECT_NEAR(early.presence, 7.0 / 9.0, 1e-9);
  ASSERT_TRUE(early.alternative);
  EXPECT_EQ(early.alternative->T_map_entity.t, kB);
  EXPECT_NEAR(early.alternative->presence, 1.0 / 9.0, 1e-9);
  EXPECT_NEAR(early.carried(), 1.0 / 9.0, 1e-9);
  EXPECT_EQ(late.T_map_entity.t, kB);
  EXPECT_NEAR(late.presence, 8.0 / 9.0, 1e-9);
  ASSERT_TRUE(late.alternative);
  EXPECT_EQ(late.alternative->T_map_entity.t, kA);
  EXPECT_NEAR(late.alternative->presence, 0.0, 1e-9);
  EXPECT_NEAR(late.carried(), 1.0 / 9.0, 1e-9);
  // Where it is known there is no other place.
  EXPECT_FALSE(query.where({3}, at(1.0)).alternative);
  EXPECT_FALSE(query.where({3}, at(30.0)).alternative);
}

TEST(SceneQuery, PresenceDecaysFasterForWhatMoved) {
  SessionBuilder builder = movedBox();
  builder.see(4, 20.0, place(kA));
  const SceneQuery query(builder.session);
  const double moved = query.where({3}, at(3600.0)).presence;
  const double unmoved = query.where({4}, at(3600.0)).presence;
  EXPECT_NEAR(unmoved, 3600.0 / (3600.0 + 3580.0), 1e-9);
  EXPECT_NEAR(moved, std::pow(3620.0 / (3620.0 + 3580.0), 2.0), 1e-9);
}

TEST(SceneQuery, BeforeItsFirstObservationAnObjectWasProbablyThere) {
  SessionBuilder builder;
  builder.keyframe(0.0);
  builder.see(4, 10.0, place(kA));
  const SceneQuery query(builder.session);
  const Whereabouts w = query.where({4}, at(0.0));
  EXPECT_EQ(w.T_map_entity.t, kA);
  EXPECT_FALSE(w.last_seen);
  EXPECT_EQ(w.next_seen, at(10.0));
  EXPECT_NEAR(w.presence, 3600.0 / 3610.0, 1e-9);
}

TEST(SceneQuery, ScansThatSeeThePlaceEmptyTell) {
  SessionBuilder builder;
  builder.scan(0.0, {kA});
  builder.see(4, 0.0, place(kA));
  builder.scan(10.0, {kA});
  const double seen_there = SceneQuery(builder.session).where({4}, at(12.0)).presence;
  builder.scan(20.0, {});
  builder.scan(30.0, {});
  const SceneQuery query(builder.session);
  EXPECT_GT(seen_there, 0.99);
  EXPECT_LT(query.where({4}, at(30.0)).presence, 0.2);
  EXPECT_GT(query.where({4}, at(9.0)).presence, 0.8);
}

TEST(SceneQuery, ScansTellWhenAnObjectMoved) {
  SessionBuilder builder;
  builder.scan(0.0, {kA});
  builder.see(4, 0.0, place(kA));
  for (const double t : {10.0, 20.0, 30.0}) builder.scan(t, {kA});
  for (const double t : {40.0, 50.0, 60.0}) builder.scan(t, {kB});
  builder.scan(100.0, {kB});
  builder.see(4, 100.0, place(kB), true);
  const SceneQuery query(builder.session);
  EXPECT_EQ(query.where({4}, at(29.0)).T_map_entity.t, kA);
  EXPECT_GT(query.where({4}, at(29.0)).presence, 0.95);
  EXPECT_EQ(query.where({4}, at(41.0)).T_map_entity.t, kB);
  EXPECT_GT(query.where({4}, at(41.0)).presence, 0.95);
}

TEST(SceneQuery, TellsMovesWithTheirWindow) {
  const SessionBuilder builder = movedBox();
  const SceneQuery query(builder.session);
  const auto moves = query.moved();
  ASSERT_EQ(moves.size(), 1u);
  EXPECT_EQ(moves[0].entity, EntityId{3});
  EXPECT_EQ(moves[0].T_map_before.t, kA);
  EXPECT_EQ(moves[0].T_map_after.t, kB);
  EXPECT_EQ(moves[0].last_before, at(2.0));
  EXPECT_EQ(moves[0].first_after, at(12.0));
  EXPECT_DOUBLE_EQ(moves[0].distance(), 1.0);
  EXPECT_EQ(query.moved(at(0.0), at(1.0)).size(), 0u);
  EXPECT_EQ(query.moved(at(5.0), at(6.0)).size(), 1u);
  EXPECT_EQ(query.moved(at(13.0), at(30.0)).size(), 0u);
}

TEST(SceneQuery, TellsHowLikelyAMoveHappenedThen) {
  const SessionBuilder builder = movedBox();
  const SceneQuery query(builder.session, slowlyCarried());
  const auto likely = [&](double from, double to) {
    return query.moved(at(from), at(to)).at(0).probability;
  };
  EXPECT_EQ(likely(0.0, 30.0), 1.0);
  EXPECT_EQ(likely(2.0, 12.0), 1.0);
  // It left at some time from 2 to 11 s and came a second later.
  EXPECT_NEAR(likely(2.0, 6.5), 4.5 / 9.0, 1e-9);
  EXPECT_NEAR(likely(6.5, 12.0), 5.5 / 9.0, 1e-9);
  EXPECT_NEAR(likely(5.0, 7.0), 3.0 / 9.0, 1e-9);
}

TEST(SceneQuery, ScansTellWhenAMoveHappened) {
  SessionBuilder builder;
  builder.scan(0.0, {kA});
  builder.see(4, 0.0, place(kA));
  for (const double t : {10.0, 20.0, 30.0}) builder.scan(t, {kA});
  for (const double t : {40.0, 50.0, 60.0}) builder.scan(t, {kB});
  builder.scan(100.0, {kB});
  builder.see(4, 100.0, place(kB), true);
  const SceneQuery query(builder.session);
  EXPECT_GT(query.moved(at(29.0), at(41.0)).at(0).probability, 0.9);
  EXPECT_LT(query.moved(at(0.0), at(29.0)).at(0).probability, 0.05);
  EXPECT_LT(query.moved(at(41.0), at(100.0)).at(0).probability, 0.05);
}

/// A box at A, then some sightings elsewhere, then at A again as often as before.
std::size_t movesAfter(const std::vector<Vector3>& elsewhere, bool comes_back) {
  SessionBuilder builder;
  builder.keyframe(0.0);
  for (int i = 0; i < 4; ++i) builder.see(3, i, place(kA));
  double t = 10.0;
  bool moved = true;
  for (const Vector3& p : elsewhere) {
    builder.see(3, t++, place(p), moved);
    moved = false;
  }
  for (int i = 0; comes_back && i < 4; ++i) builder.see(3, 30.0 + i, place(kA), i == 0);
  const SceneQuery query(builder.session);
  EXPECT_GT(query.where({3}, at(10.0)).presence, 0.999);
  if (query.moved().empty()) {
    EXPECT_EQ(query.where({3}, at(10.0)).T_map_entity.t, kA);
  }
  return query.moved().size();
}

TEST(SceneQuery, AWrongSightingIsNoMove) {
  const Vector3 beside = kA + Vector3(0.19, 0.0, 0.0), away = kA + Vector3(0.0, 1.0, 0.0);
  EXPECT_EQ(movesAfter({beside}, true), 0u);
  EXPECT_EQ(movesAfter({beside, beside}, true), 0u) << "fewer than before and after";
  EXPECT_EQ(movesAfter({beside}, false), 0u);
  EXPECT_EQ(movesAfter({beside, beside}, false), 1u) << "confirmed";
  EXPECT_EQ(movesAfter({away}, true), 2u) << "further than a sighting is wrong by";
  EXPECT_EQ(movesAfter({away}, false), 1u);
}

TEST(SceneQuery, AWrongSightingInTheBeginningIsNoMove) {
  SessionBuilder builder;
  builder.keyframe(0.0);
  builder.see(3, 0.0, place(kA + Vector3(0.16, 0.0, 0.0)));
  builder.see(3, 1.0, place(kA), true);
  for (int i = 2; i < 5; ++i) builder.see(3, i, place(kA));
  const SceneQuery query(builder.session);
  EXPECT_TRUE(query.moved().empty());
  EXPECT_EQ(query.where({3}, at(0.0)).T_map_entity.t, kA);
}

TEST(SceneQuery, WhatTheCovariancesExplainIsNoMove) {
  SessionBuilder builder;
  builder.keyframe(0.0);
  for (int i = 0; i < 3; ++i) builder.see(3, i, place(kA));
  for (int i = 3; i < 9; ++i) builder.see(3, i, place(kA + Vector3(0.1, 0.0, 0.0)), i == 3);
  EXPECT_EQ(SceneQuery(builder.session).moved().size(), 1u);
  for (auto& [node, covariance] : builder.session.entity_covariances) covariance *= 25.0;
  EXPECT_TRUE(SceneQuery(builder.session).moved().empty());
}

/// Rays pass through the place of an object that is seen all the time, as through a table: that
/// they do so afterwards says nothing.
TEST(SceneQuery, AnObjectThatScansMissIsNotGoneForThem) {
  const auto presence = [](bool missed_while_seen) {
    SessionBuilder builder;
    builder.scan(0.0, {kA});
    builder.see(4, 0.0, place(kA));
    for (int i = 1; i <= 20; ++i) {
      builder.scan(i, missed_while_seen ? std::vector<Vector3>() : std::vector<Vector3>{kA});
      builder.see(4, i, place(kA));
    }
    for (int i = 21; i <= 25; ++i) builder.scan(i, {});
    return SceneQuery(builder.session).where({4}, at(26.0)).presence;
  };
  EXPECT_LT(presence(false), 0.01);
  EXPECT_GT(presence(true), 0.9);
}

TEST(SceneQuery, NamesNoMoveThatTheFinalEstimatesTakeBack) {
  SessionBuilder builder;
  builder.keyframe(0.0);
  builder.see(3, 0.0, place(kA));
  builder.see(3, 10.0, place(kA + Vector3(0.02, 0.0, 0.0)), true);
  builder.see(3, 20.0, place(kA));
  EXPECT_TRUE(SceneQuery(builder.session).moved().empty());
}

TEST(SceneQuery, APushInViewIsOneMove) {
  SessionBuilder builder;
  builder.keyframe(0.0);
  builder.see(3, 0.0, place(kA));
  for (int i = 1; i <= 5; ++i) builder.see(3, i, place(kA + Vector3(0.0, 0.2 * i, 0.0)), true);
  builder.see(3, 6.0, place(kB));
  const SceneQuery query(builder.session);
  const auto moves = query.moved();
  ASSERT_EQ(moves.size(), 1u);
  EXPECT_NEAR(moves[0].distance(), 1.0, 1e-12);
  EXPECT_EQ(moves[0].last_before, at(0.0));
  EXPECT_EQ(moves[0].first_after, at(5.0));
  EXPECT_NEAR(query.where({3}, at(2.5)).T_map_entity.t.y(), 0.5, 1e-9);
}

TEST(SceneQuery, TwoMovesWhileNobodyLooksAreTwo) {
  SessionBuilder builder = movedBox();
  builder.see(3, 40.0, place(kA), true);
  EXPECT_EQ(SceneQuery(builder.session).moved().size(), 2u);
}

TEST(SceneQuery, AnAgentIsOnItsWay) {
  SessionBuilder builder;
  builder.keyframe(0.0);
  builder.see(101, 1.0, place({0, 0, 1}), false, SemanticClass::kAgent, "walker");
  builder.see(101, 2.0, place({1, 0, 1}), true, SemanticClass::kAgent, "walker");
  const SceneQuery query(builder.session);
  EXPECT_TRUE(query.moved().empty());
  const Whereabouts between = query.where({101}, at(1.25));
  EXPECT_LT((between.T_map_entity.t - Vector3(0.25, 0, 1)).norm(), 1e-12);
  EXPECT_GT(between.presence, 0.9);
  const Whereabouts later = query.where({101}, at(12.0));
  EXPECT_EQ(later.T_map_entity.t, Vector3(1, 0, 1));
  EXPECT_LT(later.presence, 0.05);
  EXPECT_GT((*later.covariance)(0, 0), (*between.covariance)(0, 0));
  EXPECT_EQ(query.where({101}, at(2.0)).presence, 1.0);
}

TEST(SceneQuery, NearListsTheNearestFirst) {
  SessionBuilder builder = movedBox();
  builder.see(4, 1.0, place({3.0, 0.4, 0.0}));
  const SceneQuery query(builder.session);
  const auto ids = [](const std::vector<Whereabouts>& list) {
    std::vector<std::int64_t> values;
    for (const auto& w : list) values.push_back(w.entity.value);
    return values;
  };
  EXPECT_EQ(ids(query.near(kA, 0.5, at(1.0))), (std::vector<std::int64_t>{3, 4}));
  EXPECT_EQ(ids(query.near(kA, 0.5, at(20.0))), (std::vector<std::int64_t>{4}));
  EXPECT_EQ(ids(query.near(kB, 2.0, at(20.0))), (std::vector<std::int64_t>{3, 4}));
}

}  // namespace
}  // namespace dynemo::test
