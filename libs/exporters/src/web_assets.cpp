#include "web_assets.h"

// The assembler reads the files: they cost no compile time and need no generated source.
#define DYNEMO_ASSET(name, file)    \
  __asm__(                          \
      ".pushsection .rodata\n"      \
      ".global dynemo_asset_" #name \
      "\n"                          \
      "dynemo_asset_" #name         \
      ":\n"                         \
      ".incbin \"" file             \
      "\"\n"                        \
      ".global dynemo_asset_" #name \
      "_end\n"                      \
      "dynemo_asset_" #name         \
      "_end:\n"                     \
      ".byte 0\n"                   \
      ".popsection\n");             \
  extern "C" const char dynemo_asset_##name[], dynemo_asset_##name##_end[]

DYNEMO_ASSET(page, DYNEMO_VIEWER "/viewer.html");
DYNEMO_ASSET(style, DYNEMO_VIEWER "/viewer.css");
DYNEMO_ASSET(script, DYNEMO_VIEWER "/viewer.js");
DYNEMO_ASSET(license, DYNEMO_VIEWER "/three-license.txt");
DYNEMO_ASSET(three, DYNEMO_THREE_JS);
DYNEMO_ASSET(controls, DYNEMO_ORBIT_CONTROLS_JS);

namespace dynemo {
namespace {

std::string_view between(const char* begin, const char* end) {
  return {begin, static_cast<std::size_t>(end - begin)};
}

}  // namespace

std::string_view viewerPage() { return between(dynemo_asset_page, dynemo_asset_page_end); }
std::string_view viewerStyle() { return between(dynemo_asset_style, dynemo_asset_style_end); }
std::string_view viewerScript() { return between(dynemo_asset_script, dynemo_asset_script_end); }
std::string_view threeScript() { return between(dynemo_asset_three, dynemo_asset_three_end); }
std::string_view controlsScript() {
  return between(dynemo_asset_controls, dynemo_asset_controls_end);
}
std::string_view threeLicense() { return between(dynemo_asset_license, dynemo_asset_license_end); }

}  // namespace dynemo
