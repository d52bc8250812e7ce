#include <benchmark/benchmark.h>

#include <numbers>

#include "dynemo/perception/entity_detector.h"
#include "dynemo/perception/perception_params.h"
#include "synthetic_scan.h"
#include "tag_scene.h"

namespace dynemo {
namespace {

using std::numbers::pi;

constexpr double kNoise_grey = 2.0;
constexpr double kCorner_px = 0.08, kScan_m = 0.01;

CameraModel cameraOfSize(int width, int height) {
  CameraModel camera = test::testCamera(DistortionModel::kPlumbBob);
  camera.cx *= static_cast<double>(width) / camera.width;
  camera.cy *= static_cast<double>(height) / camera.height;
  camera.width = width;
  camera.height = height;
  return camera;
}

/// Three boxes at 2, 3.5 and 5 m, with sensor noise.
SensorFrame imageFrame(const EntityModels& models, const CameraModel& camera) {
  CameraImage image;
  image.model = camera;
  image.T_base_camera = test::forwardCamera();
  image.grey = test::blankImage(camera);
  const std::array<Pose3, 3> poses{test::uprightAhead(2.0, pi + 0.5, 0.6),
                                   test::uprightAhead(3.5, pi - 0.4, -0.8),
                                   test::uprightAhead(5.0, 0.3, 0.3)};
  for (std::size_t i = 0; i < poses.size(); ++i) {
    test::drawTags(models.all()[i], models.tagFamily(), camera, poses[i], image.grey);
  }
  std::mt19937 generator(1);
  std::normal_distribution<double> noise(0.0, kNoise_grey);
  for (auto pixel = image.grey.begin<std::uint8_t>(); pixel != image.grey.end<std::uint8_t>();
       ++pixel) {
    *pixel = cv::saturate_cast<std::uint8_t>(*pixel + noise(generator));
  }
  SensorFrame frame;
  frame.images.push_back(std::move(image));
  return frame;
}

EntityModels threeBoxes() {
  std::vector<EntityModel> boxes;
  for (int i = 0; i < 3; ++i) {
    boxes.push_back(test::boxEntity(EntityId{i}));
    for (TagModel& tag : boxes.back().tags) tag.tag_id += 10 * i;
  }
  return EntityModels(std::move(boxes));
}

void detectTags(benchmark::State& state) {
  const EntityModels models = threeBoxes();
  const SensorFrame frame = imageFrame(
      models, cameraOfSize(static_cast<int>(state.range(0)), static_cast<int>(state.range(1))));
  PerceptionParams params;
  params.tag_finder.decimate = static_cast<double>(state.range(2)) / 10.0;
  const auto detector = entityDetectors().make("apriltag", params, models);
  std::size_t found = 0;
  for (auto _ : state) found = detector->detect(frame).size();
  state.counters["entities"] = static_cast<double>(found);
}
BENCHMARK(detectTags)
    ->ArgNames({"width", "height", "decimate_tenths"})
    ->Args({640, 480, 10})
    ->Args({640, 480, 15})
    ->Args({640, 480, 20})
    ->Args({848, 480, 10})
    ->Args({848, 480, 15})
    ->Unit(benchmark::kMillisecond);

void solvePose(benchmark::State& state) {
  const CameraModel camera = test::testCamera(DistortionModel::kPlumbBob);
  const EntityModel box = test::boxEntity(EntityId{1});
  std::mt19937 generator(1);
  const double yaw = state.range(0) == 1 ? pi + 0.1 : pi + 0.7;
  const auto corners =
      test::visibleCorners(box, camera, test::uprightAhead(2.0, yaw), kCorner_px, generator);
  for (auto _ : state) benchmark::DoNotOptimize(solveEntityPose(box, camera, corners, {}));
  state.counters["tags"] = static_cast<double>(corners.size());
}
BENCHMARK(solvePose)->ArgName("tags")->Arg(1)->Arg(2)->Unit(benchmark::kMicrosecond);

void cutFragments(benchmark::State& state) {
  test::Scene scene;
  scene.boxes.push_back({Pose3::translation(2.0, 0.0, 0.25), Vector3(0.25, 0.25, 0.25)});
  scene.boxes.push_back({Pose3::translation(3.0, 1.5, 0.3), Vector3(0.3, 0.2, 0.3)});
  scene.boxes.push_back({Pose3::translation(2.46, 0.0, 1.25), Vector3(0.06, 5.0, 1.25)});
  const auto simulated =
      test::castScan(scene, Pose3::translation(0.0, 0.0, 0.12), Pose3::translation(0.0, 0.0, 0.5),
                     static_cast<int>(state.range(0)), static_cast<int>(state.range(1)), kScan_m);
  EntityObservation observation;
  observation.T_base_entity = Pose3::translation(2.0, 0.0, 0.13);
  std::size_t points = 0;
  for (auto _ : state) points = extractFragments(simulated.scan, {observation}, {})[0].size();
  state.counters["points"] = static_cast<double>(points);
}
BENCHMARK(cutFragments)
    ->ArgNames({"rings", "columns"})
    ->Args({32, 512})
    ->Args({64, 1024})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace dynemo
