// trim, split, decimate, merge
#include "../common/number_range.h"
#include "commands.h"
#include "rewrite_options.h"

namespace dynemo {
namespace {

void declareTrim(CLI::App& program, std::vector<Command>& commands) {
  struct Options : RewriteArguments {
    TimeRange range;
  };
  auto o = std::make_shared<Options>();
  auto* command = program.add_subcommand("trim", "Keep a range of time");
  declareRewrite(*command, *o);
  auto* from = command->add_option("--from", o->range.from_s, "First second that is kept");
  auto* to = command->add_option("--to", o->range.to_s, "First second that is not kept any more");
  for (auto* option : {from, to}) option->type_name("SECONDS");
  command->add_flag("--unix", o->range.unix_time,
                    "The range is in UNIX time, not in seconds after the first observation");
  commands.push_back({command, [o] {
                        return printReport(trimRawlog(o->input, o->output, o->range, o->options()));
                      }});
}

void declareSplit(CLI::App& program, std::vector<Command>& commands) {
  struct Options : RewriteArguments {
    double duration_s = 0.0;
  };
  auto o = std::make_shared<Options>();
  auto* command = program.add_subcommand(
      "split", "Cut into parts of equal duration: FILE_01.rawlog, FILE_02.rawlog, ...");
  declareRewrite(*command, *o);
  command->add_option("--every", o->duration_s, "Duration of a part")
      ->required()
      ->check(positiveNumber())
      ->type_name("SECONDS");
  commands.push_back(
      {command,
       [o] { return printReport(splitRawlog(o->input, o->output, o->duration_s, o->options())); }});
}

void declareDecimate(CLI::App& program, std::vector<Command>& commands) {
  struct Options : RewriteArguments {
    std::vector<std::string> labels;
    Decimation decimation;
  };
  auto o = std::make_shared<Options>();
  auto* command = program.add_subcommand("decimate", "Thin observations and points");
  declareRewrite(*command, *o);
  command->add_option("--label", o->labels, "Only this sensor (repeatable); else all")
      ->type_name("LABEL")
      ->allow_extra_args(false);
  command
      ->add_option("--keep-every", o->decimation.keep_every,
                   "Keep the first of every N observations of a sensor")
      ->check(positiveNumber())
      ->type_name("N");
  command
      ->add_option("--keep-points-every", o->decimation.keep_points_every,
                   "Keep the first of every N points of a point cloud")
      ->check(positiveNumber())
      ->type_name("N");
  commands.push_back({command, [o] {
                        o->decimation.labels = {o->labels.begin(), o->labels.end()};
                        return printReport(
                            decimateRawlog(o->input, o->output, o->decimation, o->options()));
                      }});
}

void declareMerge(CLI::App& program, std::vector<Command>& commands) {
  struct Options : RewriteArguments {
    std::vector<std::filesystem::path> inputs;
  };
  auto o = std::make_shared<Options>();
  auto* command = program.add_subcommand("merge", "Join rawlogs of observations by time");
  command->add_option("RAWLOGS", o->inputs, "MRPT rawlogs to read")
      ->required()
      ->type_name("")
      ->expected(2, -1);
  declareOutput(*command, *o);
  commands.push_back(
      {command, [o] { return printReport(mergeRawlogs(o->inputs, o->output, o->options())); }});
}

}  // namespace

void declareCuts(CLI::App& program, std::vector<Command>& commands) {
  declareTrim(program, commands);
  declareSplit(program, commands);
  declareDecimate(program, commands);
  declareMerge(program, commands);
}

}  // namespace dynemo
