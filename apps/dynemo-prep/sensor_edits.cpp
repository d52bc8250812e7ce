// set-extrinsics, set-calibration, relabel, externalize-images
#include <cmath>
#include <numbers>
#include <sstream>

#include "commands.h"
#include "dynemo/core/config.h"
#include "dynemo/core/error.h"
#include "dynemo/ingest/ingest_params.h"
#include "rewrite_options.h"

namespace dynemo {
namespace {

/// A file with nothing but extrinsics, as they stand in the configuration of dynemo-slam.
struct ExtrinsicsFile {
  std::map<std::string, std::vector<double>> extrinsics;
};
void fields(FieldVisitor& v, ExtrinsicsFile& p) {
  v.table("extrinsics", p.extrinsics, "Sensor label: [x, y, z, qx, qy, qz, qw]");
}

std::vector<double> numbers(const std::string& text, const std::string& whole) {
  std::vector<double> values;
  std::istringstream in(text);
  for (std::string word; std::getline(in, word, ',');) {
    std::size_t used = 0;
    double value = std::nan("");
    try {
      value = std::stod(word, &used);
    } catch (const std::exception&) {
    }
    if (used != word.size() || !std::isfinite(value))
      throw ConfigError("--sensor " + whole + ": '" + word + "' is not a number");
    values.push_back(value);
  }
  return values;
}

constexpr const char* kPoseForms =
    "LABEL=X,Y,Z,YAW,PITCH,ROLL in metres and degrees, or LABEL=X,Y,Z,QX,QY,QZ,QW";

/// As kPoseForms says.
void addSensor(const std::string& text, IngestParams& params) {
  const auto equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    throw ConfigError("--sensor " + text + ": must be " + kPoseForms);
  auto row = numbers(text.substr(equals + 1), text);
  if (row.size() != 6 && row.size() != 7)
    throw ConfigError("--sensor " + text + ": has " + std::to_string(row.size()) +
                      " numbers; must be " + kPoseForms);
  if (row.size() == 6) {
    constexpr double kRad = std::numbers::pi / 180.0;
    const auto q =
        Pose3::fromYawPitchRoll(0, 0, 0, row[3] * kRad, row[4] * kRad, row[5] * kRad).quaternion();
    row = {row[0], row[1], row[2], q.x(), q.y(), q.z(), q.w()};
  }
  params.extrinsics[text.substr(0, equals)] = row;
}

void declareSetExtrinsics(CLI::App& program, std::vector<Command>& commands) {
  struct Options : RewriteArguments {
    std::vector<std::string> sensors;
    std::filesystem::path file;
  };
  auto o = std::make_shared<Options>();
  auto* command =
      program.add_subcommand("set-extrinsics", "Correct where the sensors sit on the robot");
  declareRewrite(*command, *o);
  command
      ->add_option("--sensor", o->sensors,
                   std::string(kPoseForms) +
                       ": pose of the sensor in the base frame, for cameras of the optical frame "
                       "(repeatable)")
      ->type_name("LABEL=POSE")
      ->allow_extra_args(false);
  command
      ->add_option("--file", o->file,
                   "YAML file with a table 'extrinsics:' of LABEL: [x, y, z, qx, qy, qz, qw]")
      ->type_name("FILE");
  commands.push_back({command, [o] {
                        IngestParams params;
                        if (!o->file.empty()) {
                          ConfigLoader loader;
                          loader.addFile(o->file);
                          ExtrinsicsFile file;
                          load(loader, file);
                          params.extrinsics = file.extrinsics;
                        }
                        for (const std::string& sensor : o->sensors) addSensor(sensor, params);
                        if (params.extrinsics.empty())
                          throw ConfigError("--sensor or --file is required");
                        return printReport(setExtrinsics(o->input, o->output,
                                                         extrinsicsTable(params), o->options()));
                      }});
}

void declareSetCalibration(CLI::App& program, std::vector<Command>& commands) {
  struct Options : RewriteArguments {
    std::string label;
    std::filesystem::path file;
  };
  auto o = std::make_shared<Options>();
  auto* command = program.add_subcommand("set-calibration", "Set the intrinsics of a camera");
  declareRewrite(*command, *o);
  command->add_option("--label", o->label, "Sensor label of the camera")
      ->required()
      ->type_name("LABEL");
  command
      ->add_option("--file", o->file,
                   "YAML file as ROS' camera_calibration and MRPT's camera-calib write it")
      ->required()
      ->type_name("FILE");
  commands.push_back({command, [o] {
                        return printReport(setCalibration(o->input, o->output, o->label,
                                                          readCalibration(o->file), o->options()));
                      }});
}

/// [CLASS:]OLD=NEW
LabelChange labelChange(const std::string& text) {
  const auto equals = text.rfind('=');
  if (equals == std::string::npos || equals + 1 == text.size())
    throw ConfigError("--label " + text + ": must be OLD=NEW or CLASS:OLD=NEW");
  LabelChange change{.from = text.substr(0, equals), .to = text.substr(equals + 1)};
  const auto colon = change.from.find(':');
  if (change.from.starts_with("CObservation") && colon != std::string::npos) {
    change.class_name = change.from.substr(0, colon);
    change.from = change.from.substr(colon + 1);
  }
  return change;
}

void declareRelabel(CLI::App& program, std::vector<Command>& commands) {
  struct Options : RewriteArguments {
    std::vector<std::string> labels;
    bool merge = false;
  };
  auto o = std::make_shared<Options>();
  auto* command = program.add_subcommand("relabel", "Rename sensors");
  declareRewrite(*command, *o);
  command
      ->add_option("--label", o->labels,
                   "OLD=NEW, or CLASS:OLD=NEW for one class only (repeatable)")
      ->required()
      ->type_name("OLD=NEW")
      ->allow_extra_args(false);
  command->add_flag("--merge", o->merge,
                    "Let several sensors get the same label, as one; else that is refused");
  commands.push_back({command, [o] {
                        std::vector<LabelChange> changes;
                        for (const std::string& text : o->labels)
                          changes.push_back(labelChange(text));
                        return printReport(relabelRawlog(
                            o->input, o->output, changes,
                            o->merge ? SameLabel::kMerge : SameLabel::kRefuse, o->options()));
                      }});
}

void declareExternalizeImages(CLI::App& program, std::vector<Command>& commands) {
  struct Options : RewriteArguments {
    std::string format = "png";
    int quality = 95;
  };
  auto o = std::make_shared<Options>();
  auto* command = program.add_subcommand("externalize-images",
                                         "Move images from inside the log to files beside it");
  declareRewrite(*command, *o);
  command->add_option("--format", o->format, "png (lossless, the default) or jpg")
      ->check(CLI::Validator(
          [](const std::string& text) {
            return text == "png" || text == "jpg" ? "" : text + ": must be png or jpg";
          },
          ""))
      ->type_name("png|jpg");
  command->add_option("--quality", o->quality, "Of jpg files")
      ->check(CLI::Validator(CLI::Range(1, 100)).description(""))
      ->type_name("1..100");
  commands.push_back({command, [o] {
                        const auto format =
                            o->format == "jpg" ? ImageFormat::kJpeg : ImageFormat::kPng;
                        return printReport(externalizeImages(o->input, o->output, format,
                                                             o->quality, o->options()));
                      }});
}

}  // namespace

void declareSensorEdits(CLI::App& program, std::vector<Command>& commands) {
  declareSetExtrinsics(program, commands);
  declareSetCalibration(program, commands);
  declareRelabel(program, commands);
  declareExternalizeImages(program, commands);
}

}  // namespace dynemo
