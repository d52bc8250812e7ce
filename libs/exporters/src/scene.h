// The whole scene of a run as MRPT objects.
#pragma once

#include <mrpt/opengl/COpenGLScene.h>

#include "scene_style.h"

namespace dynemo {

mrpt::opengl::COpenGLScene makeScene(const RunResult& run, const SceneParams& params);

}  // namespace dynemo
