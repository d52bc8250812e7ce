// annotate, import, export
#include <algorithm>
#include <iostream>

#include "../dynemo-slam/config_layers.h"
#include "commands.h"
#include "dynemo/core/error.h"
#include "dynemo/prep/annotate.h"
#include "dynemo/prep/kitti_export.h"
#include "dynemo/rosbag/rosbag_import.h"
#include "rewrite_options.h"

namespace dynemo {
namespace {

namespace fs = std::filesystem;

void printWarnings(const std::map<std::string, std::uint64_t>& warnings) {
  for (const auto& [what, count] : warnings)
    std::cerr << "warning     " << what << ": " << count << '\n';
}

int finishOutput() {
  std::cout << std::flush;
  if (!std::cout) throw DataError("standard output: cannot be written");
  return 0;
}

void declareConfig(CLI::App& command, ConfigLayers& config) {
  command.add_option("--config", config.file, "Configuration of dynemo-slam")->type_name("FILE");
  command.add_option("--set", config.overrides, "One key of it, e.g. sensors.lidar.label=top")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
}

/// TOPIC or TOPIC=LABEL.
std::map<std::string, std::string> topicLabels(const std::vector<std::string>& texts) {
  std::map<std::string, std::string> labels;
  for (const std::string& text : texts) {
    const auto equals = text.find('=');
    if (equals != std::string::npos) {
      labels[text.substr(0, equals)] = text.substr(equals + 1);
      continue;
    }
    std::string label = text.substr(std::min(text.size(), text.find_first_not_of('/')));
    std::replace(label.begin(), label.end(), '/', '_');
    labels[text] = label;
  }
  for (const auto& [topic, label] : labels)
    if (topic.empty() || label.empty())
      throw ConfigError("--topic: must be TOPIC or TOPIC=LABEL, neither of them empty");
  return labels;
}

int import(const fs::path& bag, const fs::path& output, const RosbagImportParams& params) {
  const RosbagImportReport report = importRosbag(bag, output, params);
  for (const auto& [sensor, count] : report.written)
    std::cout << "written     " << count << " of " << sensor << '\n';
  for (const auto& [topic, count] : report.left_out)
    std::cout << "left out    " << count << " of " << topic << '\n';
  if (!report.base_frame.empty()) std::cout << "base frame  " << report.base_frame << '\n';
  std::cout << "file        " << output.string() << '\n';
  printWarnings(report.warnings);
  return finishOutput();
}

}  // namespace

void declareAnnotate(CLI::App& program, std::vector<Command>& commands) {
  struct Options : RewriteArguments {
    ConfigLayers config;
    fs::path entities;
    bool drop_images = false;
  };
  auto o = std::make_shared<Options>();
  auto* command = program.add_subcommand(
      "annotate", "Store the entity detections in a copy, so that later runs need no camera");
  declareRewrite(*command, *o);
  command->add_option("--entities", o->entities, "Entity file")->required()->type_name("FILE");
  command->add_flag("--drop-images", o->drop_images, "Leave the images out of the copy");
  declareConfig(*command, o->config);
  commands.push_back({command, [o] {
                        const DynemoParams config = loadParams(o->config);
                        const EntityModels models = EntityModels::load(o->entities);
                        const auto report = annotateRawlog(
                            o->input, o->output, models,
                            {config.sensors, config.perception, o->drop_images}, o->options());
                        std::cout << "images      " << report.images << " searched\ndetections  "
                                  << report.detections << '\n';
                        return printReport(report);
                      }});
}

void declareImport(CLI::App& program, std::vector<Command>& commands) {
  struct Options {
    fs::path bag, output;
    std::vector<std::string> topics;
    RosbagImportParams params;
  };
  auto o = std::make_shared<Options>();
  auto* command = program.add_subcommand("import", "Make a rawlog of a ROS 1 bag");
  command->add_option("BAG", o->bag, "ROS 1 bag to read")->required()->type_name("");
  command->add_option("-o,--output", o->output, "Rawlog to write; must not exist")
      ->required()
      ->type_name("FILE.rawlog");
  command
      ->add_option("--topic", o->topics,
                   "Only this topic, and the label it gets (repeatable); else all that are known")
      ->type_name("TOPIC[=LABEL]")
      ->allow_extra_args(false);
  command
      ->add_option("--base-frame", o->params.base_frame,
                   "The robot's frame in tf; else base_link or base_footprint")
      ->type_name("FRAME");
  commands.push_back({command, [o] {
                        o->params.labels = topicLabels(o->topics);
                        return import(o->bag, o->output, o->params);
                      }});
}

void declareExport(CLI::App& program, std::vector<Command>& commands) {
  struct Options {
    fs::path rawlog, output;
    ConfigLayers config;
    bool as_recorded = false;
  };
  auto o = std::make_shared<Options>();
  auto* command = program.add_subcommand(
      "export", "Write clouds, images, stamps and poses as files, in KITTI's layout");
  command->add_option("RAWLOG", o->rawlog, "MRPT rawlog to read")->required()->type_name("");
  command->add_option("-o,--output", o->output, "Folder to write; must not exist")
      ->required()
      ->type_name("DIR");
  command->add_flag("--as-recorded", o->as_recorded,
                    "Leave lens distortion in the images, which are rectified otherwise; "
                    "calib_cam_to_cam.txt tells it");
  declareConfig(*command, o->config);
  commands.push_back({command, [o] {
                        const auto report = exportKitti(
                            o->rawlog, o->output, loadParams(o->config).sensors,
                            o->as_recorded ? KittiImages::kAsRecorded : KittiImages::kRectified);
                        std::cout << "clouds      " << report.clouds << "\nimages      "
                                  << report.images << "\nrectified   " << report.rectified
                                  << "\nposes       " << report.poses << "\nfolder      "
                                  << o->output.string() << '\n';
                        printWarnings(report.warnings);
                        return finishOutput();
                      }});
}

}  // namespace dynemo
