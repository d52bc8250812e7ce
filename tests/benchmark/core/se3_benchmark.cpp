#include <benchmark/benchmark.h>

#include <vector>

#include "dynemo/core/config.h"
#include "dynemo/core/noise.h"
#include "dynemo/core/se3.h"

namespace dynemo {
namespace {

std::vector<Pose3> poses() {
  std::vector<Pose3> list;
  Pose3 T;
  for (int i = 0; i < 256; ++i) {
    T = T.retract((Vector6() << 0.3, -0.2, 0.1, 0.4, 0.1 * (i % 7), -0.3).finished());
    list.push_back(T);
  }
  return list;
}

void BM_Compose(benchmark::State& state) {
  const auto list = poses();
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(list[i % 256] * list[(i + 1) % 256]);
    ++i;
  }
}
BENCHMARK(BM_Compose);

void BM_Local(benchmark::State& state) {
  const auto list = poses();
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(local(list[i % 256], list[(i + 3) % 256]));
    ++i;
  }
}
BENCHMARK(BM_Local);

void BM_Retract(benchmark::State& state) {
  const auto list = poses();
  const Vector6 d = Vector6::Constant(0.1);
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(list[i % 256].retract(d));
    ++i;
  }
}
BENCHMARK(BM_Retract);

void BM_SquareRootInformation(benchmark::State& state) {
  const MatrixX omega = isotropicCovariance(2.0, 3.0);
  for (auto _ : state) benchmark::DoNotOptimize(squareRootInformation(omega));
}
BENCHMARK(BM_SquareRootInformation);

struct SomeParams {
  double a = 1, b = 2, c = 3;
  bool d = true;
};
void fields(FieldVisitor& v, SomeParams& p) {
  v.number("a", p.a, "First");
  v.number("b", p.b, "Second");
  v.number("c", p.c, "Third");
  v.flag("d", p.d, "Fourth");
}

void BM_LoadConfig(benchmark::State& state) {
  for (auto _ : state) {
    ConfigLoader loader;
    loader.addText("{a: 3, b: 4, c: 5, d: false}", "text");
    SomeParams params;
    load(loader, params);
    benchmark::DoNotOptimize(params);
  }
}
BENCHMARK(BM_LoadConfig)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace dynemo
