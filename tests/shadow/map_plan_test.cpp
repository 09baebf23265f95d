// Plans of instanced maps, without GL: a map for each yaw where they are few, own maps where no shared one serves, and memory
// that is kept by rule, on every scene that is bundled.
#include "base/error.h"
#include "base/random.h"
#include "scenegen/library.h"
#include "shadow/instanced/map_atlas.h"
#include "shadow/instanced/map_plan.h"
#include "shadow/instanced/volume.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

namespace dapple::shadow {
namespace {

scenegen::Prototype block(const char* name, glm::vec3 size) {
    scenegen::Prototype p;
    p.name = name;
    p.meshes.push_back({{{0, 0, 0}, {size.x, 0, 0}, {size.x, size.y, size.z}}, {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}}, {}, {0, 1, 2}, 0});
    return p;
}

/// Items of whole prototypes, as GpuScene makes them.
gpuscene::Items itemsOf(const scenegen::Scene& scene) {
    std::vector<gpuscene::Part> parts;
    for (uint32_t p = 0; p < scene.prototypes.size(); ++p) {
        const scenegen::Prototype& prototype = scene.prototypes[p];
        parts.push_back({p, prototype.box(), prototype.castsShadow, prototype.triangles(), {}});
    }
    return {scene, std::move(parts)};
}

/// All in reach; looks fall with the distance from the first view's eye.
CasterView fromFirstView(const gpuscene::Items& items) {
    CasterView view{std::vector<bool>(items.size(), true), {}};
    for (const base::Box& box : items.boxes()) {
        const double radius = glm::length(glm::dvec3(box.halfSize()));
        view.looks.push_back(radius / std::max(radius, glm::distance(glm::dvec3(box.centre()), items.scene().views.front().eye)));
    }
    return view;
}

MapPlan plan(const scenegen::Scene& scene, const Settings& axes, const std::function<CasterView(const gpuscene::Items&)>& view = fromFirstView) {
    const gpuscene::Items items = itemsOf(scene);
    const Settings settings = resolve(technique("instanced"), axes);
    MapBounds bounds;
    bounds.bytes = std::stoul(settings.at("memory")) << 20;
    return planMaps(items, std::vector<bool>(scene.prototypes.size(), false), settings, bounds, 0, [&] { return view(items); });
}

/// A block of 10 m at each yaw (degrees), in a row from the corner of a ground of 1,200 m.
scenegen::Scene row(const std::vector<double>& yaws) {
    scenegen::Scene scene;
    scene.materials.push_back({});
    scene.prototypes.push_back(block("block", {10, 6, 8}));
    scene.prototypes.push_back(block("ground", {1200, 1200, 0}));
    scene.prototypes[1].castsShadow = false;
    scene.views.push_back({"eye", {0, -30, 2}});
    for (size_t i = 0; i < yaws.size(); ++i) scene.instances.push_back({{50 * float(i), 0, 0}, 1, float(glm::radians(yaws[i])), 0});
    scene.instances.push_back({{0, 0, 0}, 1, 0, 1});
    return scene;
}

TEST(MapPlan, FewYawsHaveAMapEach) {
    const auto anglesOf = [](const std::vector<double>& yaws, const char* rotations) {
        const MapPlan p = plan(row(yaws), {{"rotations", rotations}});
        EXPECT_EQ(p.types.size(), 1u);
        EXPECT_EQ(p.sides.size(), p.types[0].angles.size());
        return std::pair(p.types[0].ring, p.types[0].angles.size());
    };
    EXPECT_EQ(anglesOf({45, -45, 135, -135, 45, 45}, "12"), std::pair(false, size_t(4)));
    EXPECT_EQ(anglesOf({45, 45 - 360, 405, 45.0001}, "12"), std::pair(false, size_t(1)));
    EXPECT_EQ(anglesOf({0, 11, 22, 33}, "4"), std::pair(false, size_t(4)));
    EXPECT_EQ(anglesOf({0, 11, 22, 33, 44}, "4"), std::pair(true, size_t(4)));
    EXPECT_EQ(anglesOf({0, 180, 90}, "2"), std::pair(true, size_t(2)));
    EXPECT_EQ(anglesOf({0, 10}, "1"), std::pair(true, size_t(1)));
}

// A yaw that changes while the scene moves has no map of its own, unless its caster is the only one.
TEST(MapPlan, CastersThatDriveShareARing) {
    scenegen::Scene two = row({0, 90}), one = row({90});
    for (scenegen::Scene* scene : {&two, &one}) scene->motions.push_back({0, {0, 0, 0}, {50, 0, 0}, 5});
    EXPECT_TRUE(plan(two, {}).types[0].ring);
    const MapPlan alone = plan(one, {});
    EXPECT_FALSE(alone.types[0].ring);
    EXPECT_TRUE(alone.types[0].alone);
}

// Axis `own` goes to casters whose yaw lies between two maps: not to those of few yaws, nor to one on a ring's own angle.
TEST(MapPlan, OwnMapsGoWhereNoSharedOneServes) {
    EXPECT_EQ(plan(row({45, -45, 135, -135}), {{"own", "12"}}).types.size(), 1u);
    std::vector<double> yaws{0, 30, 60, 90, 120, 150, 180};  // on a ring of 12; the rest between
    for (int i = 0; i < 9; ++i) yaws.push_back(7 + 31 * i);
    const scenegen::Scene scene = row(yaws);
    for (const auto& [own, expected] : {std::pair("12", size_t(9)), {"4", 4}, {"0", 0}}) {
        const MapPlan p = plan(scene, {{"own", own}});
        ASSERT_EQ(p.types.size() - p.firstOwn, expected) << own;
        const std::vector<double> looks = fromFirstView(itemsOf(scene)).looks;
        std::vector<double> turned(looks.begin() + 7, looks.begin() + 16);
        std::ranges::sort(turned, std::greater());
        const double least = expected > 0 ? turned[expected - 1] : 0;
        for (size_t t = p.firstOwn; t < p.types.size(); ++t) {
            EXPECT_GE(p.types[t].item, 7u);
            EXPECT_GE(looks[p.types[t].item], least) << "others look larger";
            EXPECT_EQ(p.types[t].angles, std::vector{double(scene.instances[p.types[t].item].yaw)});
        }
    }
}

TEST(MapPlan, SidesShrinkWithTheExtentsAndNoFurtherThanTheyMust) {
    base::Random random(11, 0, 0);
    for (int trial = 0; trial < 200; ++trial) {
        std::vector<double> extents(1 + size_t(trial) % 40);
        for (double& e : extents) e = std::exp(6 * double(random.next()));
        const std::vector<int> wishes(extents.size(), trial % 3 == 0 ? 500 : 512);
        const size_t all = extents.size() * size_t(wishes[0]) * size_t(wishes[0]) * 4;
        const MapBounds bounds{16384, 2048, size_t(double(all) * (0.02 + 1.2 * double(random.next())))};
        const std::vector<int> sides = sidesWithin(wishes, extents, bounds);
        if (bounds.bytes >= all) {
            EXPECT_EQ(sides, wishes);
            continue;
        }
        if (sides.empty()) {
            EXPECT_LT(bounds.bytes, (extents.size() + 1) * kLeastSide * kLeastSide * 4);
            continue;
        }
        EXPECT_LE(pagesFor(sides, bounds.maxSide, bounds.maxPages).texels() * 4, bounds.bytes);
        for (size_t a = 0; a < sides.size(); ++a) {
            EXPECT_TRUE(sides[a] >= kLeastSide && sides[a] <= wishes[a] && (sides[a] & (sides[a] - 1)) == 0) << sides[a];
            for (size_t b = 0; b < sides.size(); ++b)
                EXPECT_TRUE(extents[a] > extents[b] || sides[a] <= sides[b]);
        }
        // A step less far, each map may be twice as large at most: then the sum must not fit, with a page to spare.
        const size_t used = std::accumulate(sides.begin(), sides.end(), size_t(0), [](size_t sum, int s) { return sum + size_t(s) * size_t(s) * 4; });
        EXPECT_GT(4 * used + 512 * 512 * 4, bounds.bytes);
    }
}

// Layers are bound, too: 5,000 maps are more than 2,048 layers of their own size.
TEST(MapPlan, KeepsTheLayersOfGl) {
    const std::vector<int> wishes(5000, 16);
    const std::vector<double> extents(5000, 1.0);
    EXPECT_EQ(sidesWithin(wishes, extents, {16384, 2048, 512u << 20}), wishes);
    EXPECT_TRUE(sidesWithin(wishes, extents, {16, 2048, 512u << 20}).empty());
}

TEST(MapPlan, MemoryIsKeptByRule) {
    const scenegen::Scene scene = scenegen::loadScene("city-vienna");
    const gpuscene::Items items = itemsOf(scene);
    size_t wanted = 0, sentBefore = 0, omittedAlways = 0;
    for (const char* memory : {"8192", "512", "64", "8", "1"}) {
        SCOPED_TRACE(memory);
        const auto near = [](const gpuscene::Items& all) {
            CasterView view = fromFirstView(all);
            for (uint32_t i = 0; i < all.size(); ++i) view.inReach[i] = view.looks[i] > 0.005;
            return view;
        };
        const MapPlan p = plan(scene, {{"memory", memory}}, near);
        const size_t bound = std::stoul(memory) << 20;
        EXPECT_LE(p.bytes, bound);
        EXPECT_EQ(p.note.empty(), p.wantedBytes <= bound);
        EXPECT_EQ(p.byView, p.wantedBytes > bound);
        EXPECT_TRUE(wanted == 0 || p.wantedBytes == wanted);
        wanted = p.wantedBytes;
        EXPECT_GT(wanted, size_t(1) << 30);
        size_t sent = 0, omitted = 0;
        const CasterView view = near(items);
        for (uint32_t i = 0; i < items.size(); ++i) {
            if (!items.part(i).castsShadow) continue;
            const bool mapped = p.sharedTypeOf[i] >= 0, cascaded = p.cascaded[i];
            EXPECT_FALSE(mapped && cascaded);
            EXPECT_TRUE(mapped || cascaded || (p.byView && !view.inReach[i])) << "a caster in reach is lost";
            sent += cascaded;
            omitted += !mapped && !cascaded;
        }
        EXPECT_GE(sent, sentBefore);
        sentBefore = sent;
        omittedAlways += p.byView && omitted == 0;
    }
    EXPECT_EQ(omittedAlways, 0u);
    EXPECT_GT(sentBefore, 100u) << "1 MiB sends casters to the far field";
}

TEST(MapPlan, WithoutAFarFieldTheReasonIsALine) {
    std::vector<double> yaws;
    for (int i = 0; i < 3000; ++i) yaws.push_back(0.1 * i);
    const scenegen::Scene scene = row(yaws);
    for (const Settings& axes : {Settings{{"apply", "tiled"}}, {{"apply", "all"}}, {{"accumulate", "stencil"}}}) {
        Settings tight = axes;
        tight.insert({{"memory", "1"}, {"mode", "exact"}});
        try {
            plan(scene, tight);
            FAIL();
        } catch (const base::Error& e) {
            EXPECT_NE(std::string(e.what()).find("more memory"), std::string::npos) << e.what();
            EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos);
        }
    }
    EXPECT_FALSE(plan(scene, {{"memory", "1"}, {"mode", "exact"}}).note.empty());
}

// A whole quarter in one piece, beside houses: its own map would be coarser than one of the whole scene.
TEST(MapPlan, WhatIsTooLargeForAMapGoesToTheFarField) {
    scenegen::Scene scene = row({0, 10, 20});
    scene.prototypes.push_back(block("quarter", {700, 700, 30}));
    scene.instances.push_back({{0, 0, 0}, 1, 0, 2});
    const MapPlan p = plan(scene, {});
    EXPECT_EQ(p.cascaded, (std::vector<bool>{false, false, false, false, true}));
    EXPECT_NE(p.note.find("cascaded for 1 of 4 casters"), std::string::npos) << p.note;
    EXPECT_FALSE(plan(scene, {{"size", "4096"}}).cascaded[4]) << "a larger map shows it";
    const std::vector<bool> coarse = plan(scene, {{"size", "16"}}).cascaded;
    EXPECT_EQ(std::ranges::count(coarse, true), 1) << "houses keep the coarse maps that were asked for";
    EXPECT_FALSE(plan(scene, {{"apply", "tiled"}}).cascaded[4]) << "nothing else could";
}

// Every bundled scene, at its size: both presets plan within their memory, or what refuses them is known.
TEST(MapPlan, EveryBundledSceneFits) {
    size_t scenes = 0;
    for (const scenegen::SceneEntry& entry : scenegen::listScenes()) {
        SCOPED_TRACE(entry.name);
        const scenegen::Scene scene = scenegen::loadScene(entry.name);
        const gpuscene::Items items = itemsOf(scene);
        for (const TechniqueInfo& info : techniques()) {
            if (const auto reason = pruneReason(info, info.defaults, scene.facts(), {})) {
                EXPECT_FALSE(reason->empty());
                continue;
            }
            if (info.family != "instanced") continue;
            const MapPlan p = planMaps(items, std::vector<bool>(scene.prototypes.size(), false), info.defaults, {}, 0, [&] { return fromFirstView(items); });
            EXPECT_LE(p.bytes, size_t(512) << 20);
            EXPECT_TRUE(p.wantedBytes <= size_t(512) << 20 || !p.note.empty());
        }
        ++scenes;
    }
    EXPECT_GE(scenes, 20u);
}

}  // namespace
}  // namespace dapple::shadow
