#include "rewrite_options.h"

#include <iostream>

#include "dynemo/core/error.h"

namespace dynemo {

void declareOutput(CLI::App& command, RewriteArguments& arguments) {
  command.add_option("-o,--output", arguments.output, "Rawlog to write; must not exist")
      ->required()
      ->type_name("FILE.rawlog");
  command.add_flag("--link-images", arguments.link_images,
                   "Hard-link external images instead of copying them");
}

void declareRewrite(CLI::App& command, RewriteArguments& arguments) {
  command.add_option("RAWLOG", arguments.input, "MRPT rawlog to read")->required()->type_name("");
  declareOutput(command, arguments);
}

int printReport(const RewriteReport& report) {
  std::cout << "read        " << report.read << " objects\n";
  for (const auto& [label, count] : report.edited)
    std::cout << "changed     " << count << " of '" << label << "'\n";
  std::cout << "written     " << report.written << " objects\n";
  for (const auto& file : report.files) std::cout << "file        " << file.string() << '\n';
  for (const auto& [what, count] : report.warnings)
    std::cerr << "warning     " << what << ": " << count << '\n';
  std::cout << std::flush;
  if (!std::cout) throw DataError("standard output: cannot be written");
  return 0;
}

}  // namespace dynemo
