#include "scenegen/city/house.h"
#include "scenegen/city/plan.h"
#include "scenegen/city/tower.h"
#include "scenegen/library.h"

#include <benchmark/benchmark.h>

namespace {
using namespace dapple::scenegen;
using namespace dapple::scenegen::city;

/// Streets, blocks, parcels and houses as closed prisms with roofs, without facades: as many as the counter says.
void massing(benchmark::State& state) {
    size_t houses = 0, triangles = 0;
    for (auto _ : state) {
        houses = triangles = 0;
        const Plan plan = layOut(Style::vienna, 11.6e6, 1);
        for (size_t b = 0; b < plan.blocks.size(); ++b) {
            const Region& lot = plan.blocks[b].lot;
            Parts parts;
            for (const Region& parcel : subdivide(lot, {380, 820, 13, 0.35, 0}, b)) addHouse(parts, parcel, lot, {5, 0, ++houses}, nullptr);
            triangles += parts.wall.triangles() + parts.roof.triangles();
            benchmark::DoNotOptimize(parts);
        }
    }
    state.counters["houses"] = double(houses);
    state.counters["triangles"] = benchmark::Counter(double(triangles), benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(massing)->Unit(benchmark::kMillisecond);

void plan(benchmark::State& state) {
    for (auto _ : state) benchmark::DoNotOptimize(layOut(Style::vienna, 0.9e6, 1));
}
BENCHMARK(plan)->Unit(benchmark::kMicrosecond);

void tower(benchmark::State& state) {
    size_t triangles = 0;
    for (auto _ : state) {
        const Parts parts = towerParts({10, 10, true, true, true, int(state.range(0)), 2}, 1);
        triangles = parts.wall.triangles() + parts.trim.triangles() + parts.glass.triangles() + parts.roof.triangles();
    }
    state.counters["triangles"] = benchmark::Counter(double(triangles), benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(tower)->DenseRange(0, kTowerStyles - 1)->Unit(benchmark::kMicrosecond);

void cityScene(benchmark::State& state, const char* name) {
    for (auto _ : state) benchmark::DoNotOptimize(loadScene(name));
}
BENCHMARK_CAPTURE(cityScene, vienna, "city-vienna")->Unit(benchmark::kMillisecond);

}  // namespace
