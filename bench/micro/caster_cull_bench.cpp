// Casters that can darken a view, of a forest that grows about it: one by one, and by subtrees of the hierarchy.
#include "shadow/map/caster_cull.h"

#include "base/random.h"

#include <benchmark/benchmark.h>

#include <cmath>

namespace dapple::shadow {
namespace {

/// Trees of 10 m, one on 100 m², all about the eye; the view ends at 300 m.
struct Forest {
    explicit Forest(int64_t trees) {
        const float reach = 5 * std::sqrt(float(trees));
        base::Random random(1, 2, 3);
        for (int64_t i = 0; i < trees; ++i) {
            const glm::vec3 at(random.next(-reach, reach), random.next(-reach, reach), 0);
            boxes.push_back({at - glm::vec3(3, 3, 0), at + glm::vec3(3, 3, 10)});
        }
        hierarchy = gpuscene::Hierarchy(boxes, std::vector<uint32_t>(boxes.size(), 3500), {});
        const base::DBox world{{-reach, -reach, 0}, {reach, reach, 10}};
        const frame::Camera camera({"view", eye, {0, 1, 0}, {0, 0, 1}, 60, 0.3, 300}, 1024, 768);
        const glm::dvec3 light = glm::normalize(glm::dvec3(-1, 1, -1));
        cull.emplace(lightBasis(light, {0, 0, 1}), camera, viewBody(camera, camera.near, camera.far, {world.lo - eye, world.hi - eye}), 0.5);
    }
    glm::dvec3 eye{0, 0, 2};
    std::vector<base::Box> boxes;
    gpuscene::Hierarchy hierarchy;
    std::optional<CasterCull> cull;
};

void castersOneByOne(benchmark::State& state) {
    const Forest forest(state.range(0));
    size_t kept = 0;
    for (auto _ : state) {
        std::vector<uint32_t> casters;
        for (uint32_t i = 0; i < forest.boxes.size(); ++i)
            if (forest.cull->keep({glm::dvec3(forest.boxes[i].lo) - forest.eye, glm::dvec3(forest.boxes[i].hi) - forest.eye})) casters.push_back(i);
        kept = casters.size();
    }
    state.counters["kept"] = double(kept);
}
BENCHMARK(castersOneByOne)->ArgName("trees")->Arg(100)->Arg(1000)->Arg(10'000)->Arg(100'000)->Unit(benchmark::kMicrosecond);

void castersBySubtrees(benchmark::State& state) {
    const Forest forest(state.range(0));
    size_t kept = 0;
    for (auto _ : state) kept = forest.cull->kept(forest.hierarchy, forest.boxes, forest.eye).size();
    state.counters["kept"] = double(kept);
}
BENCHMARK(castersBySubtrees)->ArgName("trees")->Arg(100)->Arg(1000)->Arg(10'000)->Arg(100'000)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace dapple::shadow
