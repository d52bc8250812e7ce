// What the commands that write rawlogs have in common.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>

#include "dynemo/prep/rewrite.h"

namespace dynemo {

struct RewriteArguments {
  std::filesystem::path input, output;
  bool link_images = false;

  RewriteOptions options() const {
    return {.images = link_images ? ImageTransfer::kHardLink : ImageTransfer::kCopy};
  }
};

/// Adds RAWLOG, --output and --link-images.
void declareRewrite(CLI::App& command, RewriteArguments& arguments);
/// Adds --output and --link-images.
void declareOutput(CLI::App& command, RewriteArguments& arguments);

/// Prints what was read, edited and written; warnings go to stderr. Returns exit status 0.
int printReport(const RewriteReport& report);

}  // namespace dynemo
