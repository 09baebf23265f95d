#include "visibility/occlusion_culler.h"

#include "base/random.h"
#include "visibility/views.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

namespace dapple::visibility {
namespace {

using gpuscene::Hierarchy;

/// Answers 0 to 5 polls late, whatever the answers are.
class LateDevice : public QueryDevice {
public:
    void begin() override {
        EXPECT_FALSE(asking);
        asking = true;
    }
    void end() override {
        EXPECT_TRUE(asking);
        asking = false;
    }
    Query issue(const Hierarchy& hierarchy, const CullView& view, std::span<const uint32_t> nodes) override {
        EXPECT_TRUE(asking);
        EXPECT_FALSE(nodes.empty());
        pending[next] = {answer(hierarchy, view, nodes), latest > 0 ? uint64_t(random.next(0, float(latest) + 1)) : 0};
        ++issued;
        boxes += nodes.size();
        return Query(next++);
    }
    std::optional<uint64_t> poll(Query query) override {
        auto& [samples, polls] = pending.at(uint32_t(query));
        if (polls-- > 0) return {};
        return wait(query);
    }
    uint64_t wait(Query query) override {
        const uint64_t samples = pending.at(uint32_t(query)).first;
        pending.erase(uint32_t(query));
        return samples;
    }
    virtual uint64_t answer(const Hierarchy&, const CullView&, std::span<const uint32_t> nodes) = 0;

    int latest = 5;
    bool asking = false;
    uint64_t issued = 0, boxes = 0;
    uint32_t next = 0;
    std::map<uint32_t, std::pair<uint64_t, int64_t>> pending;
    base::Random random{99, 0, 0};
};

struct World {
    std::vector<base::Box> boxes;
    Hierarchy hierarchy;
};

/// Houses on a street grid with small things between: much hides much.
World town(int houses) {
    World world;
    base::Random random(3, 0, 0);
    for (int i = 0; i < houses; ++i) {
        const bool house = i % 3 == 0;
        const glm::vec3 at(random.next(-60, 60), random.next(-60, 60), 0), size = house ? glm::vec3(random.next(3, 9), random.next(3, 9), random.next(5, 15)) : glm::vec3(random.next(0.02f, 1), 0.3f, random.next(0.3f, 2));
        world.boxes.push_back({at, at + size});
    }
    world.boxes.push_back({{-70, -70, -1}, {70, 70, 0}});
    world.hierarchy = Hierarchy(world.boxes, std::vector<uint32_t>(world.boxes.size(), 100), {150, 1});
    return world;
}

constexpr int kWidth = 40, kHeight = 30;
constexpr double kNear = 0.2;

/// One ray through each pixel's centre; solid boxes, cut by the near plane. Draws and answers exactly, by brute force.
class Raster : public LateDevice, public LeafRenderer {
public:
    Raster(const World& w, const CullView& v) : world(w), view(v), depth(kWidth * kHeight, 1e30), owner(depth.size(), -1) {
        const glm::dmat4 relativeFromClip = glm::inverse(v.clipFromRelative);
        const auto unproject = [&](double x, double y, double z) {
            const glm::dvec4 p = relativeFromClip * glm::dvec4(x, y, z, 1);
            return glm::dvec3(p) / p.w;
        };
        for (int y = 0; y < kHeight; ++y)
            for (int x = 0; x < kWidth; ++x) {
                const double nx = (2 * x + 1.0) / kWidth - 1, ny = (2 * y + 1.0) / kHeight - 1;
                const glm::dvec3 a = unproject(nx, ny, v.parallel ? 0 : 1), b = unproject(nx, ny, v.parallel ? 1 : 0.5);
                rays.push_back({a, b - a});
            }
    }
    static double entry(const std::pair<glm::dvec3, glm::dvec3>& ray, const base::DBox& box, bool clamped) {
        double in = clamped ? -1e30 : 0, out = 1e30;
        for (int k = 0; k < 3; ++k) {
            const double a = (box.lo[k] - ray.first[k]) / ray.second[k], b = (box.hi[k] - ray.first[k]) / ray.second[k];
            in = std::max(in, std::min(a, b));
            out = std::min(out, std::max(a, b));
        }
        return in <= out ? in : 1e30;
    }
    void draw(std::span<const uint32_t> leaves) override {
        EXPECT_FALSE(asking);
        for (const uint32_t leaf : leaves)
            for (const uint32_t item : world.hierarchy.items(leaf)) {
                const base::DBox box = view.relative(world.boxes[item]);
                for (size_t i = 0; i < rays.size(); ++i) {
                    const double t = entry(rays[i], box, view.parallel);
                    if (t >= depth[i]) continue;
                    depth[i] = t;
                    owner[i] = int(leaf);
                }
            }
        drawn.insert(drawn.end(), leaves.begin(), leaves.end());
    }
    uint64_t answer(const Hierarchy& h, const CullView& v, std::span<const uint32_t> nodes) override {
        uint64_t samples = 0;
        for (const uint32_t n : nodes)
            for (size_t i = 0; i < rays.size(); ++i) samples += entry(rays[i], v.relative(h.nodes()[n].box), v.parallel) < depth[i];
        return samples;
    }

    const World& world;
    CullView view;
    std::vector<std::pair<glm::dvec3, glm::dvec3>> rays;
    std::vector<double> depth;
    std::vector<int> owner;
    std::vector<uint32_t> drawn;
};

std::vector<uint32_t> leavesOf(const Hierarchy& hierarchy) {
    std::vector<uint32_t> leaves;
    for (uint32_t n = 0; n < hierarchy.nodes().size(); ++n)
        if (hierarchy.nodes()[n].leaf()) leaves.push_back(n);
    return leaves;
}

void expectNoneTwice(std::vector<uint32_t> drawn) {
    std::sort(drawn.begin(), drawn.end());
    EXPECT_EQ(std::adjacent_find(drawn.begin(), drawn.end()), drawn.end());
}

/// Forwards, so that a query left over from the last frame is answered by the device that got it.
class Relay : public LateDevice, public LeafRenderer {
public:
    uint64_t answer(const Hierarchy& h, const CullView& v, std::span<const uint32_t> nodes) override { return raster->answer(h, v, nodes); }
    void draw(std::span<const uint32_t> leaves) override {
        EXPECT_FALSE(asking);
        raster->draw(leaves);
    }
    Raster* raster = nullptr;
};

CullView randomCamera(base::Random& random) {
    const glm::dvec3 eye(random.next(-55, 55), random.next(-55, 55), random.next(0.5f, random.next() < 0.2f ? 40 : 3));
    const glm::dvec3 forward(random.next(-1, 1), random.next(-1, 1), random.next(-0.4f, 0.1f));
    return CullView::camera(eye, cameraMatrix(forward, 0.8, 0.6, kNear, 300), kNear);
}
CullView randomSun(base::Random& random) {
    const glm::dvec3 l = glm::normalize(glm::dvec3(random.next(-1, 1), random.next(-1, 1), random.next(-1.5f, -0.1f)));
    const glm::dvec3 eye(random.next(-40, 40), random.next(-40, 40), 1);
    return CullView::sun(eye, sunMatrix(l, random.next(5, 50), -100, 100), l);
}

struct Variant {
    Algorithm algorithm;
    int batch, assumed;
    bool sun;
};
const Variant kVariants[] = {{Algorithm::chc, 1, 0, false}, {Algorithm::chc, 1, 0, true}, {Algorithm::chcpp, 1, 0, false}, {Algorithm::chcpp, 7, 5, false},
                             {Algorithm::chcpp, 50, 10, false}, {Algorithm::chcpp, 50, 5, true}, {Algorithm::frustum, 1, 0, false}};

CullSettings settingsOf(const Variant& variant) { return {.algorithm = variant.algorithm, .batch = variant.batch, .assumedVisible = variant.assumed}; }

// Against an exact image: nothing that is seen is missing, in any frame, though the view jumps about; and walks between.
TEST(OcclusionCuller, DrawsWhateverIsSeen) {
    const World world = town(400);
    const Hierarchy& hierarchy = world.hierarchy;
    for (const Variant& variant : kVariants) {
        OcclusionCuller culler(hierarchy, settingsOf(variant));
        ViewState state;
        Relay device;
        base::Random random(17, 0, 0);
        CullView view;
        uint64_t leavesDrawn = 0, leavesInFrustum = 0;
        for (int frame = 0; frame < 40; ++frame) {
            const bool jump = frame < 20 || frame % 10 == 0;
            if (jump) view = variant.sun ? randomSun(random) : randomCamera(random);
            else view.eye += glm::dvec3(0.3, 0.2, 0);
            if (frame == 25) state.reset();
            Raster everything(world, view), culled(world, view);
            everything.draw(leavesOf(hierarchy));
            device.raster = &culled;
            const uint64_t issued = device.issued, boxes = device.boxes;
            culler.cull(view, state, device, device);
            ASSERT_EQ(culled.depth, everything.depth) << "frame " << frame;
            const std::set<uint32_t> drawn(culled.drawn.begin(), culled.drawn.end());
            for (const int owner : everything.owner) ASSERT_TRUE(owner < 0 || drawn.contains(uint32_t(owner)));
            expectNoneTwice(culled.drawn);
            EXPECT_TRUE(std::equal(culled.drawn.begin(), culled.drawn.end(), culler.leaves().begin(), culler.leaves().end()));
            EXPECT_FALSE(device.asking);

            const Statistics& s = culler.statistics();
            uint64_t triangles = 0;
            for (const uint32_t leaf : drawn) triangles += hierarchy.nodes()[leaf].triangles;
            EXPECT_EQ(s.trianglesDrawn, triangles);
            EXPECT_EQ(s.leavesDrawn, drawn.size());
            EXPECT_EQ(s.queries, device.issued - issued);
            EXPECT_EQ(s.boxes, device.boxes - boxes);
            EXPECT_LE(s.failedMultiqueries, s.multiqueries);
            EXPECT_LE(s.wastedBoxes, s.boxes);
            EXPECT_LE(s.nodesVisible, s.nodesVisited);
            EXPECT_GE(s.queries, s.bursts);
            leavesDrawn += drawn.size();
            for (const uint32_t leaf : leavesOf(hierarchy)) leavesInFrustum += view.mayContain(view.relative(hierarchy.nodes()[leaf].box));
        }
        if (variant.algorithm == Algorithm::frustum) { EXPECT_EQ(leavesDrawn, leavesInFrustum); }
        else if (!variant.sun) { EXPECT_LT(leavesDrawn, leavesInFrustum / 2); }
    }
}

/// Visibility by decree: what is in the set, and whatever holds it, is visible.
class Script : public LateDevice, public LeafRenderer {
public:
    uint64_t answer(const Hierarchy& h, const CullView&, std::span<const uint32_t> nodes) override {
        return uint64_t(std::any_of(nodes.begin(), nodes.end(), [&](uint32_t n) { return std::any_of(h.items(n).begin(), h.items(n).end(), [&](uint32_t i) { return visible.contains(i); }); }));
    }
    void draw(std::span<const uint32_t> leaves) override { drawn.insert(drawn.end(), leaves.begin(), leaves.end()); }
    std::set<uint32_t> visible;  // items
    std::vector<uint32_t> drawn;
};

/// A line of items before an orthographic camera, a leaf each.
World row(uint32_t count) {
    World world;
    for (uint32_t i = 0; i < count; ++i) world.boxes.push_back({{float(i), 0, 0}, {float(i) + 0.5f, 1, 1}});
    world.hierarchy = Hierarchy(world.boxes, std::vector<uint32_t>(count, 10), {1, 0.01});
    return world;
}
const CullView kAll = CullView::sun({0, 0, 0}, sunMatrix({0, 0, -1}, 1e4, -10, 10), {0, 0, -1});

// Random scripts: what the script shows is drawn, and beyond it only what it showed in the frames that visibility is assumed for.
TEST(OcclusionCuller, FollowsRandomScripts) {
    const World world = row(200);
    for (const int latest : {0, 1, 5})
        for (const Variant& variant : kVariants) {
            if (variant.algorithm == Algorithm::frustum) continue;
            OcclusionCuller culler(world.hierarchy, settingsOf(variant));
            ViewState state;
            Script script;
            script.latest = latest;
            std::vector<std::set<uint32_t>> shown;
            for (int frame = 0; frame < 60; ++frame) {
                const float share = frame % 7 == 0 ? 0.9f : frame % 5 == 0 ? 0 : 0.1f;
                if (frame % 3 != 1) script.visible.clear();  // else it adds to the last frame's
                for (uint32_t i = 0; i < 200; ++i)
                    if (script.random.next() < share) script.visible.insert(i);
                shown.push_back(script.visible);
                script.drawn.clear();
                culler.cull(kAll, state, script, script);
                expectNoneTwice(script.drawn);
                std::set<uint32_t> items;
                for (const uint32_t leaf : script.drawn) items.insert(world.hierarchy.items(leaf).begin(), world.hierarchy.items(leaf).end());
                for (const uint32_t i : script.visible) ASSERT_TRUE(items.contains(i)) << frame;
                for (const uint32_t i : items) {
                    bool before = false;
                    for (int f = std::max(0, frame - std::max(1, variant.assumed)); f <= frame; ++f) before |= shown[size_t(f)].contains(i);
                    ASSERT_TRUE(before) << frame << ": item " << i;
                }
            }
            EXPECT_LE(script.pending.size(), 200u);
            state.reset();  // their results are fetched and dropped
            culler.cull(kAll, state, script, script);
            for (const auto& [query, late] : script.pending) EXPECT_GE(query, script.next - 200);
        }
}

TEST(OcclusionCuller, ASteadyViewCostsFewQueries) {
    const World world = row(512);
    OcclusionCuller plusplus(world.hierarchy, {}), chc(world.hierarchy, {.algorithm = Algorithm::chc});
    ViewState a, b;
    Script script;
    for (uint32_t i = 100; i < 120; ++i) script.visible.insert(i);
    Statistics settledPlus, settledChc;
    for (int frame = 0; frame < 40; ++frame) {
        plusplus.cull(kAll, a, script, script);
        if (frame >= 20) settledPlus += plusplus.statistics();
        chc.cull(kAll, b, script, script);
        if (frame >= 20) settledChc += chc.statistics();
        if (frame > 10) { EXPECT_EQ(plusplus.statistics().leavesDrawn, 20u); }
    }
    EXPECT_EQ(settledPlus.failedMultiqueries, 0u);
    EXPECT_LT(settledPlus.queries, settledChc.queries / 3);
    // A visible leaf is asked once in n_av frames; the hidden boundary takes the rest.
    EXPECT_LE(settledPlus.queries - settledPlus.multiqueries, 20u * 20 / 5 + 40);
    EXPECT_LT(settledPlus.stalls, settledChc.stalls + 1);
}

TEST(OcclusionCuller, WhatIsDrawnAlreadyIsVisibleAndLeftAlone) {
    const World world = row(64);
    const auto items = world.hierarchy.items();
    const AlreadyDrawn even = [&](uint32_t leaf) { return items[world.hierarchy.nodes()[leaf].firstItem] % 2 == 0; };
    for (const Algorithm algorithm : {Algorithm::frustum, Algorithm::chc, Algorithm::chcpp}) {
        OcclusionCuller culler(world.hierarchy, {.algorithm = algorithm});
        ViewState state;
        Script script;
        for (uint32_t i = 0; i < 64; ++i) script.visible.insert(i);
        for (int frame = 0; frame < 10; ++frame) {
            script.drawn.clear();
            culler.cull(kAll, state, script, script, even);
            EXPECT_EQ(script.drawn.size(), 32u);
            for (const uint32_t leaf : script.drawn) EXPECT_FALSE(even(leaf));
            EXPECT_EQ(culler.statistics().leavesAlreadyDrawn, 32u);
            EXPECT_EQ(culler.statistics().trianglesDrawn, 320u);
        }
        script.drawn.clear();
        culler.cull(kAll, state, script, script);  // was visible: drawn without waiting for a query
        EXPECT_EQ(script.drawn.size(), 64u);
    }
}

// A proxy that the near plane cuts may report nothing: it is not asked.
TEST(OcclusionCuller, WhatHoldsTheEyeIsDrawnWithoutAQuestion) {
    const World world = row(64);
    const CullView inside = CullView::camera({20.25, 0.5, 0.5}, cameraMatrix({1, 0, 0}, 1, 1, kNear, 300), kNear);
    for (const Algorithm algorithm : {Algorithm::chc, Algorithm::chcpp}) {
        OcclusionCuller culler(world.hierarchy, {.algorithm = algorithm});
        ViewState state;
        Script nothingPasses;
        culler.cull(inside, state, nothingPasses, nothingPasses);
        ASSERT_EQ(nothingPasses.drawn.size(), 1u);
        EXPECT_EQ(world.hierarchy.items(nothingPasses.drawn[0])[0], 20u);
    }
}

TEST(OcclusionCuller, NoNodesNoWork) {
    const Hierarchy nothing;
    OcclusionCuller culler(nothing, {});
    ViewState state;
    Script script;
    culler.cull(kAll, state, script, script);
    EXPECT_EQ(script.issued, 0u);
    EXPECT_TRUE(culler.leaves().empty());
}

TEST(Multiquery, TheCostModelsFigures) {
    const double persistence[] = {0.29, 0.73, 0.90, 0.955, 0.977, 0.985};
    for (uint32_t t = 0; t < 6; ++t) EXPECT_NEAR(keepProbability(t), persistence[t], t == 2 ? 0.006 : 0.003) << t;
    const struct {
        double keep, value;
        size_t length;
    } optima[] = {{0.29, 1, 1}, {0.90, 1.68, 4}, {0.98, 3.65, 8}, {0.99, 5.11, 11}};
    for (const auto& [keep, value, length] : optima) {
        const std::vector<double> many(100, keep);
        EXPECT_EQ(multiqueryLength(many), length) << keep;
        if (length > 1) { EXPECT_NEAR(multiqueryValue(std::span(many).first(length)), value, 0.005); }
        // By brute force over all lengths.
        size_t best = 1;
        double bestValue = 1;
        for (size_t n = 2; n <= many.size(); ++n)
            if (const double v = multiqueryValue(std::span(many).first(n)); v > bestValue) {
                best = n;
                bestValue = v;
            }
        EXPECT_EQ(best, length);
    }
    EXPECT_EQ(multiqueryLength({}), 0u);
    const double mixed[] = {0.99, 0.99, 0.99, 0.29};
    EXPECT_EQ(multiqueryLength(mixed), 3u);
}

}  // namespace
}  // namespace dapple::visibility
