// dynemo-query: questions to the map of a finished run.
#include <filesystem>
#include <iostream>
#include <optional>
#include <sstream>

#include "../common/number_range.h"
#include "../common/program.h"
#include "../common/time_argument.h"
#include "answers.h"
#include "dynemo/core/config.h"

namespace fs = std::filesystem;

namespace dynemo {
namespace {

struct Options {
  fs::path run, run_a, run_b;
  std::string entity, point;
  std::optional<std::string> at, from, to;
  double radius_m = 1.0;
  std::vector<std::string> overrides;
  bool json = false;
};

void print(const std::string& text) {
  std::cout << text << std::flush;
  if (!std::cout) throw DataError("standard output: cannot be written");
}

template <class Params>
Params paramsOf(const Options& o) {
  ConfigLoader loader;
  for (const std::string& text : o.overrides) loader.addOverride(text);
  Params params;
  load(loader, params);
  return params;
}

/// A question to one run.
class Question {
 public:
  explicit Question(const Options& o)
      : o_(o),
        session_(loadRunSession(requireRun(o))),
        query_(session_, paramsOf<QueryParams>(o)) {}

  void where() {
    const Stamp at = timeOr(o_.at, "--at", query_.end());
    const Whereabouts w = query_.where(entity(), at);
    print(o_.json ? whereJson(w, at) : whereText(w, at, query_.begin()));
  }

  void moved() {
    const Stamp from = timeOr(o_.from, "--from", query_.begin());
    const Stamp to = timeOr(o_.to, "--to", query_.end());
    if (to < from) {
      throw ConfigError(o_.to     ? "--to: is before --from"
                        : o_.from ? "--from: is after the end of the run; give --to as well"
                                  : "--to: is before the beginning of the run");
    }
    const auto moves = query_.moved(from, to);
    print(o_.json ? movedJson(moves) : movedText(moves, query_.begin()));
  }

  void near() {
    const Stamp at = timeOr(o_.at, "--at", query_.end());
    const Vector3 p_map = point();
    const auto found = query_.near(p_map, o_.radius_m, at);
    print(o_.json ? nearJson(found, p_map, at) : nearText(found, p_map, query_.begin()));
  }

  void track() {
    const EntityId id = entity();
    const auto sightings = query_.track(id);
    print(o_.json ? trackJson(sightings, query_.where(id, query_.end()))
                  : trackText(sightings, query_.begin()));
  }

  void entities() {
    const Stamp at = timeOr(o_.at, "--at", query_.end());
    std::vector<Whereabouts> all;
    for (const EntityId id : query_.entities()) all.push_back(query_.where(id, at));
    print(o_.json ? entitiesJson(all, at) : entitiesText(all, query_.begin()));
  }

 private:
  static const fs::path& requireRun(const Options& o) {
    if (o.run.empty()) throw ConfigError("RUN_DIR is required (see dynemo-query --help)");
    return o.run;
  }

  Stamp timeOr(const std::optional<std::string>& text, const char* option, Stamp otherwise) const {
    return text ? parseTime(*text, {query_.begin(), query_.end()}, option) : otherwise;
  }

  EntityId entity() const {
    const auto found = query_.find(o_.entity);
    if (!found) throw ConfigError(found.error());
    return *found;
  }

  Vector3 point() const {
    Vector3 p;
    char comma = ',';
    std::istringstream in(o_.point);
    for (int axis = 0; axis < 3; ++axis) {
      if (axis > 0) in >> comma;
      in >> p[axis];
      if (comma != ',') in.setstate(std::ios::failbit);
    }
    if (!in || in.peek() != std::char_traits<char>::eof() || !p.allFinite())
      throw ConfigError("near " + o_.point + ": must be X,Y,Z in metres");
    return p;
  }

  const Options& o_;
  Session session_;
  SceneQuery query_;
};

void diff(const Options& o) {
  if (!o.run.empty()) throw ConfigError("diff: takes RUN_A RUN_B and no RUN_DIR before it");
  const Session a = loadRunSession(o.run_a), b = loadRunSession(o.run_b);
  const auto found = difference(a, b, paramsOf<DifferenceParams>(o));
  if (!found) throw DataError(found.error());
  print(o.json ? differenceJson(*found) : differenceText(*found));
}

/// After --set, which it heeds. It needs no question: as with --help, parsing ends there.
template <class Params>
void declareDumpConfig(CLI::App& command, const Options& o) {
  command.add_flag_callback(
      "--dump-config",
      [&o] {
        print(toYaml(paramsOf<Params>(o)));
        throw CLI::Success();
      },
      "Print the parameters that --set overrides and exit");
}

template <class Params>
void declareCommon(CLI::App& command, Options& o) {
  command.add_flag("--json", o.json, "Print JSON");
  command
      .add_option("--set", o.overrides,
                  "Override one parameter of what is believed of entities, e.g. --set "
                  "object_residence_s=86400 (repeatable)")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  declareDumpConfig<Params>(command, o);
}

CLI::Option* addTime(CLI::App& command, const char* name, std::optional<std::string>& value,
                     const std::string& help) {
  return command.add_option(name, value, help + "; " + kTimeHelp)->type_name("T");
}

void declare(CLI::App& app, Options& o, std::function<void()>& answer) {
  app.add_option("RUN_DIR", o.run, "Output folder of dynemo-slam")->type_name("");
  declareDumpConfig<QueryParams>(app, o);
  app.set_version_flag("--version", "dynemo-query " DYNEMO_VERSION);
  app.require_subcommand(1);
  const auto ask = [&](const char* name, const char* help, void (Question::*question)()) {
    CLI::App* command = app.add_subcommand(name, help);
    declareCommon<QueryParams>(*command, o);
    command->callback(
        [&o, &answer, question] { answer = [&o, question] { (Question(o).*question)(); }; });
    return command;
  };
  auto* where =
      ask("where", "Where an entity is, and how likely it is still there", &Question::where);
  auto* moved =
      ask("moved", "Which objects moved, from where to where, and when", &Question::moved);
  auto* near = ask("near", "What is near a point of the map", &Question::near);
  auto* track = ask("track", "All observations of an entity", &Question::track);
  auto* entities = ask("entities", "All entities of the map", &Question::entities);
  for (auto* command : {where, track}) {
    command->add_option("ENTITY", o.entity, "Id or name of the entity")->required()->type_name("");
  }
  for (auto* command : {where, near, entities})
    addTime(*command, "--at", o.at, "At this time, else at the end");
  addTime(*moved, "--from", o.from, "Moves that may have happened after this time");
  addTime(*moved, "--to", o.to, "Moves that may have happened before this time");
  near->add_option("POINT", o.point, "Point in the map as X,Y,Z [m]")->required()->type_name("");
  near->add_option("--radius", o.radius_m, "How far from the point [m]")
      ->check(positiveNumber())
      ->type_name("R");

  auto* difference = app.add_subcommand("diff", "What changed between two sessions of one place");
  declareCommon<DifferenceParams>(*difference, o);
  difference->add_option("RUN_A", o.run_a, "The earlier run")->required()->type_name("");
  difference->add_option("RUN_B", o.run_b, "The later run")->required()->type_name("");
  difference->callback([&o, &answer] { answer = [&o] { diff(o); }; });
}

}  // namespace
}  // namespace dynemo

int main(int argc, char** argv) {
  CLI::App app("Asks the map of a run of dynemo-slam: where things are, what moved, what is near.",
               "dynemo-query");
  dynemo::Options options;
  std::function<void()> answer;
  dynemo::declare(app, options, answer);
  return dynemo::runProgram(app, argc, argv, [&] {
    answer();
    return 0;
  });
}
