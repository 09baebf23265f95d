#include "gpuscene/hierarchy.h"

#include "base/random.h"

#include <benchmark/benchmark.h>

namespace dapple::gpuscene {
namespace {

/// A million trees of 1 to 20 m on 10 km of ground.
std::vector<base::Box> forest() {
    std::vector<base::Box> boxes(1'000'000);
    base::Random random(1, 2, 3);
    for (base::Box& box : boxes) {
        const glm::vec3 at(random.next(-5000, 5000), random.next(-5000, 5000), random.next(0, 200));
        const float height = random.next(1, 20);
        box = {at - glm::vec3(height / 4, height / 4, 0), at + glm::vec3(height / 4, height / 4, height)};
    }
    return boxes;
}

// Triangles per tree: with 1,000 a leaf holds some ten trees, with 20,000 one.
void hierarchyOfAMillion(benchmark::State& state) {
    const std::vector<base::Box> boxes = forest();
    const std::vector<uint32_t> triangles(boxes.size(), uint32_t(state.range(0)));
    size_t nodes = 0;
    for (auto _ : state) nodes = Hierarchy(boxes, triangles, {}).nodes().size();
    state.counters["nodes"] = double(nodes);
}
BENCHMARK(hierarchyOfAMillion)->ArgName("triangles")->Arg(1000)->Arg(20000)->Unit(benchmark::kMillisecond)->UseRealTime();

void refitTenThousandOfAMillion(benchmark::State& state) {
    std::vector<base::Box> boxes = forest();
    const std::vector<uint32_t> triangles(boxes.size(), uint32_t(state.range(0)));
    Hierarchy hierarchy(boxes, triangles, {});
    std::vector<uint32_t> items;
    std::vector<base::Box> moved;
    for (uint32_t i = 0; i < 10'000; ++i) {
        items.push_back(i * 97 + 13);
        moved.push_back(boxes[items.back()]);
    }
    float step = 0.1f;
    for (auto _ : state) {
        for (base::Box& box : moved) box = {box.lo + step, box.hi + step};
        step = -step;
        hierarchy.refit(items, moved);
    }
}
BENCHMARK(refitTenThousandOfAMillion)->ArgName("triangles")->Arg(1000)->Arg(20000)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace dapple::gpuscene
