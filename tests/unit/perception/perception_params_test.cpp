#include "dynemo/perception/perception_params.h"

#include <gtest/gtest.h>

#include "dynemo/core/config.h"
#include "dynemo/core/error.h"

namespace dynemo {
namespace {

TEST(PerceptionParams, WhatIsDumpedLoadsBackToTheSameText) {
  PerceptionParams params;
  params.tag_finder.decimate = 2.0;
  params.ambiguity.fallback = AmbiguityParams::Fallback::kInflate;
  params.fragments.min_points = 7;
  const std::string text = toYaml(params);
  PerceptionParams loaded;
  ConfigLoader loader;
  loader.addText(text, "dump");
  load(loader, loaded);
  EXPECT_EQ(toYaml(loaded), text);
  EXPECT_EQ(loaded.tag_finder.decimate, 2.0);
  EXPECT_EQ(loaded.ambiguity.fallback, AmbiguityParams::Fallback::kInflate);
  EXPECT_EQ(loaded.fragments.min_points, 7);
}

TEST(PerceptionParams, RefusesValuesOutOfRange) {
  for (const char* text :
       {"tag_finder.decimate=0", "tag_finder.max_hamming=3", "tag_pose.max_reprojection_px=0",
        "fragments.cluster_tolerance_m=-1", "ambiguity.fallback=guess", "no_such_key=1"}) {
    PerceptionParams params;
    ConfigLoader loader;
    loader.addOverride(text);
    EXPECT_THROW(load(loader, params), ConfigError) << text;
  }
}

}  // namespace
}  // namespace dynemo
