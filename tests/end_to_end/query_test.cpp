// dynemo-query against ground truth: what moved, and where everything is.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "dynemo/evaluation/entity_data.h"
#include "dynemo/evaluation/placements.h"
#include "dynemo/evaluation/trajectory_error.h"
#include "slam_run.h"

namespace dynemo::test {
namespace {

constexpr int kUsage = 2, kData = 3;
/// What is asked for: positions right to a decimetre.
constexpr double kMaxError_m = 0.10;

Outcome ask(const Arguments& arguments) {
  Arguments command = {DYNEMO_QUERY};
  command.insert(command.end(), arguments.begin(), arguments.end());
  return runCommand(command);
}

nlohmann::json answer(const Arguments& arguments) {
  Arguments with_json = arguments;
  with_json.emplace_back("--json");
  const Outcome outcome = ask(with_json);
  EXPECT_EQ(outcome.status, 0) << describe(outcome);
  return nlohmann::json::parse(outcome.out);
}

Vector3 position(const nlohmann::json& pose) {
  const auto& p = pose.at("position_m");
  return Vector3(p.at(0).get<double>(), p.at(1).get<double>(), p.at(2).get<double>());
}

/// A run with the truth in its own map frame.
struct Judged {
  const SlamRun& run;
  EntityTruths truths;
  Pose3 T_map_world;

  Judged(const SlamRun& r, const Dataset& dataset)
      : run(r), truths(readEntityTruths(dataset.entityTruth())) {
    const auto aligned =
        alignTrajectories(readTum(dataset.truth()), readTum(run.folder() / "trajectory.tum"));
    T_map_world = aligned.value().T_reference_estimate.inverse();
  }
  Vector3 truePosition(EntityId id, Stamp stamp) const {
    return T_map_world * poseAt(truths.at(id).poses, stamp).value().t;
  }
};

std::set<EntityId> movedIds(const nlohmann::json& moved) {
  std::set<EntityId> ids;
  for (const auto& move : moved.at("moves")) ids.insert({move.at("entity").get<std::int64_t>()});
  return ids;
}

/// Every displaced object and no other; each move from the true place to the true place, in a
/// window that holds the true time.
void expectMovesRight(const Judged& judged, const Dataset& dataset) {
  const nlohmann::json moved = answer({judged.run.folder(), "moved"});
  EXPECT_EQ(movedIds(moved), displacedObjects(dataset));
  for (const auto& move : moved.at("moves")) {
    const EntityId id{move.at("entity").get<std::int64_t>()};
    SCOPED_TRACE(move.dump());
    const Stamp before = Stamp::parse(move.at("last_before")),
                after = Stamp::parse(move.at("first_after"));
    EXPECT_LT((position(move.at("T_map_before")) - judged.truePosition(id, before)).norm(),
              kMaxError_m);
    EXPECT_LT((position(move.at("T_map_after")) - judged.truePosition(id, after)).norm(),
              kMaxError_m);
    const auto placements = findPlacements(judged.truths.at(id).poses);
    const bool holds_a_change =
        std::any_of(placements.begin(), placements.end(),
                    [&](const Placement& p) { return before <= p.end && p.end <= after; });
    EXPECT_TRUE(holds_a_change);
  }
}

/// Objects at the end and whenever they were seen, agents when they were seen.
void expectPlacesRight(const Judged& judged) {
  const auto observations = readEntityEstimates(judged.run.folder() / "entities.csv");
  std::map<EntityId, std::vector<Stamp>> seen;
  for (const auto& o : observations) seen[o.entity].push_back(o.stamp);
  double worst_m = 0.0;
  for (const auto& [id, stamps] : seen) {
    const bool object = judged.truths.at(id).semantic_class == SemanticClass::kObject;
    std::vector<Stamp> times = {stamps.front(), stamps.back()};
    if (object) times.push_back(judged.truths.at(id).poses.back().stamp);
    for (const Stamp at : times) {
      const auto w =
          answer({judged.run.folder(), "where", std::to_string(id.value), "--at", at.text()});
      const double error_m = (position(w.at("T_map_entity")) - judged.truePosition(id, at)).norm();
      worst_m = std::max(worst_m, error_m);
      EXPECT_LT(error_m, kMaxError_m) << id << " at " << at.text();
      EXPECT_GE(w.at("presence"), object ? 0.5 : 0.999) << id << " at " << at.text();
      EXPECT_EQ(w.at("covariance").size(), 6u);
    }
  }
  std::cout << "worst position error of " << seen.size() << " entities: " << worst_m << " m\n";
}

TEST(QueryTruth, BundledSample) {
  const Judged judged(bundledRun("full"), bundledSample());
  expectMovesRight(judged, bundledSample());
  expectPlacesRight(judged);
}

/// A sample, and where its odometry comes from.
class QuerySample : public testing::TestWithParam<std::tuple<const char*, const char*>> {};

TEST_P(QuerySample, AgainstTruth) {
  const auto [name, odometry] = GetParam();
  const auto dataset = sample(name);
  if (!dataset) GTEST_SKIP() << "DYNEMO_SAMPLES is not set";
  const SlamRun run(*dataset, {"--set", std::string("odometry.source=") + odometry});
  ASSERT_TRUE(run.ok()) << describe(run.outcome());
  const Judged judged(run, *dataset);
  expectMovesRight(judged, *dataset);
  expectPlacesRight(judged);
}

INSTANTIATE_TEST_SUITE_P(Samples, QuerySample,
                         testing::Combine(testing::Values("mini_samo", "mini_mamo"),
                                          testing::Values("rawlog", "lidar")),
                         [](const auto& p) {
                           return std::string(std::get<0>(p.param)) + "_" + std::get<1>(p.param);
                         });

TEST(Query, HoursAfterTheRunMayBeAskedFor) {
  const fs::path run = bundledRun("full").folder();
  const double next_day = answer({run, "where", "box 2", "--at", "+86400"}).at("presence");
  const double at_the_end = answer({run, "where", "box 2"}).at("presence");
  EXPECT_LT(next_day, at_the_end);
  EXPECT_NE(
      ask({run, "where", "box 2", "--at", "+-10"}).out.find("1700000010.000000000 (-10.000 s)"),
      std::string::npos);
}

TEST(Query, AWordThatIsNoCommandIsNamedWithTheNearestOne) {
  const std::string run = "/nonexistent/run";
  const auto expectError = [](const Outcome& outcome, const std::string& text) {
    EXPECT_EQ(outcome.status, kUsage) << describe(outcome);
    EXPECT_NE(outcome.err.find(text), std::string::npos) << describe(outcome);
  };
  expectError(ask({run, "wher", "1"}), "'wher' is no command; did you mean where?");
  expectError(ask({"difff", "a", "b"}), "'difff' is no command; did you mean diff?");
  expectError(ask({run, "explain"}), "'explain' is no command; known: where, moved, near");
  expectError(ask({run}), "a command is required after '" + run + "'; known: where, moved");
  expectError(ask({"--vresion"}), "'--vresion' is no option; did you mean --version?");
  expectError(ask({run, "where", "1", "--jsn"}), "did you mean --json?");
}

TEST(Query, TellsItsParameters) {
  const Outcome one = ask({"--dump-config"}), two = ask({"diff", "--dump-config"});
  EXPECT_EQ(one.status, 0) << describe(one);
  EXPECT_NE(one.out.find("\nobject_residence_s: "), std::string::npos) << one.out;
  EXPECT_EQ(two.status, 0) << describe(two);
  EXPECT_NE(two.out.find("\nmin_agreeing: "), std::string::npos) << two.out;
  EXPECT_NE(two.out.find("\n  object_residence_s: "), std::string::npos) << two.out;
  const Outcome changed = ask({"where", "--set", "object_residence_s=17", "--dump-config"});
  EXPECT_NE(changed.out.find("object_residence_s: 17"), std::string::npos) << describe(changed);
}

TEST(Query, MovesAreAskedByTime) {
  const fs::path run = bundledRun("full").folder();
  EXPECT_TRUE(answer({run, "moved", "--to", "+1"}).at("moves").empty());
  EXPECT_FALSE(answer({run, "moved", "--from", "+20", "--to", "+35"}).at("moves").empty());
}

TEST(Query, NearIsWhereTheEntitiesAre) {
  const fs::path run = bundledRun("full").folder();
  const Vector3 p = position(answer({run, "where", "box 2"}).at("T_map_entity"));
  const std::string point =
      std::to_string(p.x()) + "," + std::to_string(p.y()) + "," + std::to_string(p.z());
  const auto near = answer({run, "near", point, "--radius", "0.01"}).at("entities");
  ASSERT_EQ(near.size(), 1u);
  EXPECT_EQ(near.at(0).at("name"), "box 2");
}

TEST(Query, TrackHasEveryObservation) {
  const fs::path run = bundledRun("full").folder();
  const auto observations = readEntityEstimates(run / "entities.csv");
  const auto of_box = std::count_if(observations.begin(), observations.end(),
                                    [](const auto& o) { return o.entity == EntityId{1}; });
  EXPECT_EQ(answer({run, "track", "1"}).at("track").size(), static_cast<std::size_t>(of_box));
  EXPECT_EQ(answer({run, "entities"}).at("entities").size(), 19u);
}

/// The beginning and the end of the sample are two sessions of one place, with maps of their own.
TEST(Query, TwoSessionsDifferByWhatWasMovedBetween) {
  const TemporaryFolder folder;
  const Dataset whole = bundledSample();
  const auto cut = [&](const std::string& name, double from_s, double to_s) {
    const KeepObservation before_from = firstSeconds(from_s), before_to = firstSeconds(to_s);
    copyRawlog(whole.rawlog(), folder / (name + ".rawlog"), [&](const auto& observation) {
      return before_to(observation) && !before_from(observation);
    });
    fs::create_directory_symlink(whole.images(), folder / (name + "_Images"));
    const Outcome run = slam({"--entities", whole.entities(), "--output", folder / name, "-q",
                              folder / (name + ".rawlog")});
    EXPECT_EQ(run.status, 0) << describe(run);
    return folder / name;
  };
  const fs::path a = cut("a", 0.0, 25.0), b = cut("b", 29.0, 100.0);
  const auto difference = answer({"diff", a, b});
  std::set<EntityId> moved, in_both;
  for (const auto& object : difference.at("objects")) {
    const EntityId id{object.at("entity").get<std::int64_t>()};
    if (object.at("change") == "moved") moved.insert(id);
    if (object.at("change") == "moved" || object.at("change") == "unchanged") in_both.insert(id);
  }
  std::set<EntityId> expected;
  for (const EntityId id : displacedObjects(whole))
    if (in_both.contains(id)) expected.insert(id);
  EXPECT_GE(in_both.size(), 4u);
  EXPECT_EQ(moved, expected) << difference.dump(1);
}

/// Two recordings of a room, each with a map of its own: what was carried, came and went.
TEST(Query, TwoRecordingsDifferByWhatWasCarried) {
  const TemporaryFolder folder;
  const auto map = [&](const std::string& day) {
    const fs::path world =
        fs::path(DYNEMO_SOURCE_DIR) / "tests" / "data" / "two_sessions" / (day + ".yaml");
    const Outcome made =
        runCommand({DYNEMO_SIMULATE, "--world", world, "--output", folder / day, "--quiet"});
    EXPECT_EQ(made.status, 0) << describe(made);
    const fs::path data = folder / day / day;
    const Outcome run =
        slam({"--entities", data.string() + "_entities.yaml", "--output", folder / ("map_" + day),
              "--set", "outputs=[session]", "-q", data.string() + ".rawlog"});
    EXPECT_EQ(run.status, 0) << describe(run);
    return folder / ("map_" + day);
  };
  const auto difference = answer({"diff", map("monday"), map("tuesday")});
  const std::map<int, std::string> expected = {{1, "moved"},     {2, "unchanged"},
                                               {3, "moved"},     {4, "disappeared"},
                                               {5, "unchanged"}, {6, "appeared"}};
  const std::map<int, double> distance_m = {{1, std::hypot(8.3 - 2.2, 0.8 - 0.7)},
                                            {2, 0.0},
                                            {3, std::hypot(2.3 - 0.7, 0.5 - 3.3)},
                                            {5, 0.0}};
  std::map<int, std::string> changes;
  for (const auto& object : difference.at("objects")) {
    const int id = object.at("entity").get<int>();
    changes[id] = object.at("change").get<std::string>();
    if (distance_m.contains(id)) {
      const double moved_m =
          (position(object.at("T_mapB_entityB")) - position(object.at("T_mapB_entityA"))).norm();
      EXPECT_NEAR(moved_m, distance_m.at(id), kMaxError_m) << id;
    }
    EXPECT_GT(object.at("certainty").get<double>(), 0.9) << id;
  }
  EXPECT_EQ(changes, expected) << difference.dump(1);
}

TEST(Query, TablesAreForPeople) {
  const fs::path run = bundledRun("full").folder();
  EXPECT_NE(ask({run, "moved"}).out.find("box 1"), std::string::npos);
  const Outcome where = ask({run, "where", "box 1", "--at", "+10"});
  for (const char* part : {"position", "sigma", "last seen", "still there"})
    EXPECT_NE(where.out.find(part), std::string::npos) << describe(where);
  EXPECT_EQ(ask({"diff", run, run}).status, 0);
}

TEST(Query, RefusesWhatItCannotAnswer) {
  const fs::path run = bundledRun("full").folder();
  const auto expectError = [](const Outcome& outcome, int status, const std::string& text) {
    EXPECT_EQ(outcome.status, status) << describe(outcome);
    EXPECT_NE(outcome.err.find(text), std::string::npos) << describe(outcome);
    EXPECT_TRUE(outcome.out.empty()) << describe(outcome);
  };
  expectError(ask({run, "where", "table"}), kUsage,
              "no entity 'table' in the map; known: 1 (box 1)");
  expectError(ask({run, "where", "1", "--at", "noon"}), kUsage, "--at noon");
  expectError(ask({run, "moved", "--from", "+40", "--to", "+20"}), kUsage, "before --from");
  expectError(ask({run / "nothing", "entities"}), kData, "no such folder");
  expectError(ask({run / "summary.json", "entities"}), kData, "is not a folder");
  expectError(ask({run, "moved", "--from", "+500"}), kUsage, "--from: is after the end of the run");
  for (const char* far_away : {"30", "-5", "+1.7e9", "+8999999999", "3400000000"}) {
    for (const Outcome& outcome : {ask({run, "where", "1", std::string("--at=") + far_away}),
                                   ask({run, "near", "1,2,3", std::string("--at=") + far_away}),
                                   ask({run, "moved", std::string("--to=") + far_away})}) {
      expectError(outcome, kUsage, "1700000020.000000000 to 1700000072.000000000 (+0 to +52.000)");
      expectError(outcome, kUsage, "+S for S seconds");
    }
  }
  expectError(ask({run, "near", "1,2,3", "--radius", "-1"}), kUsage,
              "--radius: -1: must be a number > 0");
  expectError(ask({run, "near", "1,2"}), kUsage, "near 1,2: must be X,Y,Z");
  expectError(ask({"where", "1"}), kUsage, "RUN_DIR");
  expectError(ask({run}), kUsage, "a command is required");
  expectError(ask({"/nonexistent", "moved"}), kData, "/nonexistent");
  expectError(ask({run, "where", "1", "--set", "nope=1"}), kUsage, "nope");
}

}  // namespace
}  // namespace dynemo::test
