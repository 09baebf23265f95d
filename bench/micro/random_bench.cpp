#include "base/random.h"

#include <benchmark/benchmark.h>

namespace {

/// Every vertex of a scene draws several numbers, so one must cost a few nanoseconds at most.
void randomUniform(benchmark::State& state) {
    dapple::base::Random random(1, 2, 3);
    float sum = 0;
    for (auto _ : state) benchmark::DoNotOptimize(sum += random.next());
    state.SetItemsProcessed(state.iterations());
}
BENCHMARK(randomUniform);

}  // namespace
