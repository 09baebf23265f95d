#include "base/random.h"
#include "scenegen/placement/forest.h"
#include "scenegen/terrain/height_field.h"

#include <benchmark/benchmark.h>

namespace dapple::scenegen {
namespace {

// A million trees of two species on 6 km of ground, with and without self-thinning.
void millionPlacements(benchmark::State& state) {
    const Stand stands[] = {{.share = 2, .scale = {0.8, 1.25}, .individuals = {0, 1}, .crownRadii = {2.0, 2.5}},
                            {.share = 1, .scale = {0.8, 1.25}, .individuals = {2}, .crownRadii = {1.5}}};
    const Site site{3000, [](const glm::dvec2&) { return 0.0; }, [](const glm::dvec2&) { return 0.0; }, [](const glm::dvec2&) { return true; }};
    size_t standing = 0;
    for (auto _ : state) standing = plantForest(1'000'000, 0.5, state.range(0) ? Crowding::thin : Crowding::shrink, 1, stands, site).size();
    state.counters["standing"] = double(standing);
    state.counters["sown/s"] = benchmark::Counter(1e6 * double(state.iterations()), benchmark::Counter::kIsRate);
}
BENCHMARK(millionPlacements)->ArgName("thin")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

HeightField noise(int cells) {
    HeightField field{cells + 1, cells + 1, 2, std::vector<float>(size_t(cells + 1) * size_t(cells + 1))};
    addFbm(field, {});
    field.stretch(80);
    return field;
}

void fbmTerrain(benchmark::State& state) {
    for (auto _ : state) benchmark::DoNotOptimize(noise(512));
    state.counters["samples/s"] = benchmark::Counter(513.0 * 513 * double(state.iterations()), benchmark::Counter::kIsRate);
}
BENCHMARK(fbmTerrain)->Unit(benchmark::kMillisecond);

void droplets(benchmark::State& state) {
    const HeightField start = noise(512);
    for (auto _ : state) {
        HeightField field = start;
        erode(field, 50'000, 1);
        benchmark::DoNotOptimize(field);
    }
    state.counters["droplets/s"] = benchmark::Counter(5e4 * double(state.iterations()), benchmark::Counter::kIsRate);
}
BENCHMARK(droplets)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace dapple::scenegen
