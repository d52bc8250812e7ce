// The files of the web page, as they were when this library was built.
#pragma once

#include <string_view>

namespace dynemo {

std::string_view viewerPage();      ///< viewer.html, with @…@ where the rest goes
std::string_view viewerStyle();     ///< viewer.css
std::string_view viewerScript();    ///< viewer.js
std::string_view threeScript();     ///< three.js
std::string_view controlsScript();  ///< three.js's OrbitControls
std::string_view threeLicense();

}  // namespace dynemo
