#include "scenegen/library.h"
#include "scenegen/plants/bark.h"
#include "scenegen/plants/tree.h"
#include "scenegen/plants/tube.h"

#include <benchmark/benchmark.h>

namespace {
using namespace dapple::scenegen;

void countTriangles(benchmark::State& state, size_t triangles) {
    state.counters["triangles"] = benchmark::Counter(double(triangles), benchmark::Counter::kIsIterationInvariantRate);
}

/// Control points to limit positions and normals, 16 branches at a time.
void tubes(benchmark::State& state) {
    const TubeTopology& topology = tubeTopology(6, 9, int(state.range(0)));
    std::vector<float> controls(topology.controls() * 3 * kLanes);
    for (size_t i = 0; i < controls.size(); ++i) controls[i] = float(i * 2654435761u % 1000) * 0.001f;
    std::vector<glm::vec3> positions(topology.vertices() * kLanes), normals(positions.size());
    for (auto _ : state) {
        evaluateTubes(topology, controls.data(), kLanes, positions.data(), normals.data());
        benchmark::ClobberMemory();
    }
    countTriangles(state, topology.indices.size() / 3 * kLanes);
}
BENCHMARK(tubes)->Arg(0)->Arg(1)->Arg(2);

/// Skeleton to finished buffers (positions, normals, indices) in fresh memory: trunk, limbs and twigs of one tree.
void bark(benchmark::State& state, const char* name) {
    const Species species = loadSpecies(name);
    Skeleton skeleton = growSkeleton(species, 1);
    const BarkPlan plan = planBark(species, skeleton, 0);
    for (auto _ : state) benchmark::DoNotOptimize(buildBark(species, skeleton, plan));
    countTriangles(state, plan.triangles);
}
BENCHMARK_CAPTURE(bark, oak, "oak");
BENCHMARK_CAPTURE(bark, fir, "fir");
BENCHMARK_CAPTURE(bark, willow, "willow");

/// Another individual each time, so that nothing is grown twice. The bar is 15 M triangles/s for every species.
void wholeTree(benchmark::State& state, const std::string& name, LeafMode leaves) {
    const Species species = loadSpecies(name);
    const size_t budget = species.triangles[0];
    uint64_t seed = 0;
    for (auto _ : state) benchmark::DoNotOptimize(growTree(species, {++seed, budget, leaves}));
    const Tree tree = growTree(species, {seed, budget, leaves});
    countTriangles(state, tree.bark.triangles() + tree.leaves.triangles());
}

const bool everySpecies = [] {
    constexpr std::pair<const char*, LeafMode> kModes[] = {{"polygon", LeafMode::polygon}, {"card", LeafMode::card}, {"solid", LeafMode::solid}};
    for (const std::string& name : listSpecies())
        for (const auto& [mode, leaves] : kModes) benchmark::RegisterBenchmark(("wholeTree/" + name + "/" + mode).c_str(), wholeTree, name, leaves);
    return true;
}();

/// Sixty individuals, of all species in turn, each at its three levels of detail.
void prototypes(benchmark::State& state) {
    std::vector<Species> species;
    for (const std::string& name : listSpecies()) species.push_back(loadSpecies(name));
    size_t triangles = 0;
    for (auto _ : state) {
        triangles = 0;
        for (uint64_t i = 0; i < 60; ++i) {
            const Species& s = species[i % species.size()];
            for (int lod = 0; lod < kLods; ++lod) {
                benchmark::DoNotOptimize(growTree(s, {i, s.triangles[size_t(lod)], LeafMode::polygon, lod}));
                triangles += s.triangles[size_t(lod)];
            }
        }
    }
    countTriangles(state, triangles);
}
BENCHMARK(prototypes)->Unit(benchmark::kMillisecond);

/// A recipe to a validated scene: reading, growing, placing, checking.
void scene(benchmark::State& state, const char* name) {
    for (auto _ : state) benchmark::DoNotOptimize(loadScene(name));
}
BENCHMARK_CAPTURE(scene, forest105, "forest-105")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(scene, forestSmall, "forest-small")->Unit(benchmark::kMillisecond);

}  // namespace
