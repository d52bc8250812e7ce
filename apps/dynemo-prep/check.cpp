// check, tags
#include <iostream>

#include "../common/number_range.h"
#include "../dynemo-slam/config_layers.h"
#include "commands.h"
#include "dynemo/core/error.h"
#include "dynemo/core/output_file.h"
#include "dynemo/ingest/rawlog_source.h"
#include "dynemo/prep/inspection.h"

namespace dynemo {
namespace {

namespace fs = std::filesystem;

constexpr int kNotRunnable = 1;

struct SurveyArguments {
  fs::path rawlog;
  ConfigLayers config;
  std::string family = "tag36h11";
};

void declareSurvey(CLI::App& command, SurveyArguments& o) {
  command.add_option("RAWLOG", o.rawlog, "MRPT rawlog to read")->required()->type_name("");
  command.add_option("--family", o.family, "Tag family")->type_name("NAME")->capture_default_str();
  command.add_option("--config", o.config.file, "Configuration of dynemo-slam")->type_name("FILE");
  command.add_option("--set", o.config.overrides, "One key of it, e.g. sensors.lidar.label=top")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
}

void print(const std::string& text) {
  std::cout << text << std::flush;
  if (!std::cout) throw DataError("standard output: cannot be written");
}

int check(const SurveyArguments& o, int tag_images, int odometry_scans, bool json) {
  const DynemoParams config = loadParams(o.config);
  InspectionParams params;
  params.sensors = config.sensors;
  params.odometry = config.odometry;
  params.tags.family = o.family;
  params.tags.finder = config.perception.tag_finder;
  params.tag_images = tag_images;
  params.odometry_scans = odometry_scans;
  const Inspection inspection = inspectRawlog(o.rawlog, params);
  print(json ? inspectionJson(inspection) : inspectionText(inspection));
  return inspection.runnable() ? 0 : kNotRunnable;
}

int surveyTags(const SurveyArguments& o, std::optional<double> size_m, int min_sightings,
               const fs::path& output) {
  const DynemoParams config = loadParams(o.config);
  if (fs::exists(output))
    throw DataError(output.string() + ": exists already and is not overwritten");
  prepareFolderOf(output);
  const TagSurveyParams params{o.family, config.perception.tag_finder, size_m};
  TagSurvey survey(params);
  const auto source = makeRawlogSource(config.sensors, o.rawlog);
  while (const auto frame = source->next()) survey.add(*frame);
  if (survey.imagesSearched() == 0)
    throw DataError(o.rawlog.string() + ": holds no image that can be used");
  const std::string draft =
      entityFileDraft(survey, params, min_sightings, o.rawlog.filename().string());
  writeFileAtomically(output, draft);
  print("images      " + std::to_string(survey.imagesSearched()) + "\ntags        " +
        std::to_string(survey.tags().size()) + "\nfile        " + output.string() + "\n");
  return 0;
}

}  // namespace

void declareCheck(CLI::App& program, std::vector<Command>& commands) {
  struct Options : SurveyArguments {
    bool json = false;
    int tag_images = 40, odometry_scans = 100;
  };
  auto o = std::make_shared<Options>();
  auto* command = program.add_subcommand(
      "check", "Tell what is in a rawlog, whether dynemo-slam can run it, and what to mend");
  declareSurvey(*command, *o);
  command->add_flag("--json", o->json, "For programs");
  command->add_option("--tag-images", o->tag_images, "Images of each camera searched for tags")
      ->check(nonNegativeNumber())
      ->type_name("N")
      ->capture_default_str();
  command
      ->add_option("--odometry-scans", o->odometry_scans,
                   "Scans on which LiDAR odometry is tried when the log has no other")
      ->check(nonNegativeNumber())
      ->type_name("N")
      ->capture_default_str();
  commands.push_back(
      {command, [o] { return check(*o, o->tag_images, o->odometry_scans, o->json); }});
}

void declareTags(CLI::App& program, std::vector<Command>& commands) {
  struct Options : SurveyArguments {
    std::optional<double> size_m;
    int min_sightings = 3;
    fs::path output;
  };
  auto o = std::make_shared<Options>();
  auto* command =
      program.add_subcommand("tags", "Find the tags and draft an entity file that can be edited");
  declareSurvey(*command, *o);
  command->add_option("--size", o->size_m, "Side of the black squares; else measured by the LiDAR")
      ->check(positiveNumber())
      ->type_name("METRES");
  command->add_option("--min-sightings", o->min_sightings, "Leave out tags seen less often")
      ->check(positiveNumber())
      ->type_name("N")
      ->capture_default_str();
  command->add_option("-o,--output", o->output, "Entity file to write; must not exist")
      ->required()
      ->type_name("FILE.yaml");
  commands.push_back(
      {command, [o] { return surveyTags(*o, o->size_m, o->min_sightings, o->output); }});
}

}  // namespace dynemo
