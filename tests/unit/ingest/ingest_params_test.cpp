#include "dynemo/ingest/ingest_params.h"

#include <gtest/gtest.h>

#include "dynemo/core/config.h"
#include "dynemo/core/error.h"

namespace dynemo {
namespace {

TEST(IngestParams, DefaultsRoundTripThroughYaml) {
  const std::string yaml = toYaml(IngestParams());
  ConfigLoader loader;
  loader.addText(yaml, "defaults");
  IngestParams params;
  params.lidar.max_range_m = 1.0;
  load(loader, params);
  EXPECT_EQ(toYaml(params), yaml);
}

TEST(IngestParams, EveryKindOfValueIsRead) {
  ConfigLoader loader;
  loader.addText(
      "lidar: {label: top, elevations_deg: [1, 2.5], sweep_rate_hz: 10, sweep_start_deg: 90}\n"
      "cameras: {labels: [a, b]}\n"
      "extrinsics: {top: [1, 2, 3, 0, 0, 0, 1]}\n",
      "test");
  IngestParams params;
  load(loader, params);
  EXPECT_EQ(params.lidar.label, "top");
  EXPECT_EQ(params.lidar.elevations_deg, (std::vector<double>{1, 2.5}));
  EXPECT_EQ(params.lidar.sweep_rate_hz, 10.0);
  EXPECT_NEAR(params.lidar.sweep_start_rad, std::numbers::pi / 2, 1e-12);
  EXPECT_EQ(params.cameras.labels, (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(extrinsicsTable(params).at("top").t, Vector3(1, 2, 3));
}

TEST(IngestParams, ValuesOutOfRangeAreRefused) {
  ConfigLoader loader;
  loader.addText("sync: {max_image_offset_s: -1}\nclock: {confirmations: 0}\n", "test");
  IngestParams params;
  EXPECT_THROW(load(loader, params), ConfigError);
}

}  // namespace
}  // namespace dynemo
