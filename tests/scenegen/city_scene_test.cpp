#include "base/error.h"
#include "base/hash.h"
#include "base/random.h"
#include "scenegen/city/plan.h"
#include "scenegen/library.h"
#include "recipe_error.h"
#include "winding.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <set>

using namespace dapple::scenegen;
namespace city = dapple::scenegen::city;
using testing::HasSubstr;

namespace {

class EveryCity : public testing::TestWithParam<const char*> {
protected:
    Scene load(const std::string& scale, const std::string& seed = "3") const { return loadScene(GetParam(), {"scale=" + scale, "seed=" + seed}); }
};

std::string errorOf(const std::string& city) { return recipeError("[city]\n" + city); }

}  // namespace

TEST_P(EveryCity, theTestSizeIsSmallAndWhole) {
    const Scene scene = load("0.015625");
    const Facts f = scene.facts();
    EXPECT_GT(f.triangles, 50'000u);
    EXPECT_LT(f.triangles, 4'000'000u);
    EXPECT_TRUE(f.rotated);
    EXPECT_FALSE(f.alphaTested);
    for (const Prototype& p : scene.prototypes) EXPECT_EQ(p.closed, !p.name.starts_with("street tree")) << p.name;
    std::set<uint32_t> used;
    for (const Instance& i : scene.instances) used.insert(i.prototype);
    for (uint32_t p = 0; p < scene.prototypes.size(); ++p) EXPECT_TRUE(used.contains(p) || scene.prototypes[p].triangles() < 600) << "only small furniture may lie idle";
    size_t walks = 0;
    for (const View& v : scene.views)
        if (v.name.starts_with("walk")) {
            ++walks;
            EXPECT_DOUBLE_EQ(v.eye.z, 1.7);
            EXPECT_DOUBLE_EQ(v.near, 0.3);
        }
    EXPECT_GE(walks, 4u);
    EXPECT_EQ(scene.views.back().name, "above");
}

TEST_P(EveryCity, walkersStandInTheOpen) {
    // Nothing but the ground within a metre of an eye, by the triangles of everything near.
    for (const char* seed : {"1", "2"}) {
        const Scene scene = load("0.03", seed);
        for (const View& view : scene.views)
            for (const Instance& i : scene.instances) {
                const Prototype& p = scene.prototypes[i.prototype];
                if (!p.castsShadow || p.name.starts_with("pavement")) continue;
                const dapple::base::Box box = instanceBox(p.box(), i);
                const glm::dvec3 nearest = glm::clamp(view.eye, glm::dvec3(box.lo), glm::dvec3(box.hi));
                if (glm::distance(nearest, view.eye) > 1) continue;
                const double c = std::cos(double(i.yaw)), s = std::sin(double(i.yaw));
                for (const Mesh& m : p.meshes)
                    for (const glm::vec3& v : m.positions) {
                        const glm::dvec3 w = glm::dvec3(i.translation) + double(i.scale) * glm::dvec3(c * v.x - s * v.y, s * v.x + c * v.y, v.z);
                        ASSERT_GT(glm::distance(w, view.eye), 1) << view.name << " beside " << p.name;
                    }
            }
    }
}

TEST_P(EveryCity, areaAndCostGrowWithTheScale) {
    const Facts small = load("0.03").facts(), large = load("0.12").facts();
    const double ratio = double(large.triangles) / double(small.triangles);
    EXPECT_GT(ratio, 2.5);
    EXPECT_LT(ratio, 6.5);
    const auto area = [](const Facts& f) { return double(f.box.size().x - 200) * double(f.box.size().y - 200); };
    EXPECT_NEAR(area(large) / area(small), 4, 1.5);
}

TEST_P(EveryCity, seedsRepeatAndDiffer) {
    EXPECT_EQ(load("0.015625").contentHash(), load("0.015625").contentHash());
    EXPECT_NE(load("0.015625", "4").contentHash(), load("0.015625", "5").contentHash());
}

TEST(City, atNightEveryLampLightsThePavementBelowIt) {
    const Scene scene = loadScene("city-vienna", {"scale=0.05", "city.night=true"});
    size_t lamps = 0;
    for (const Instance& i : scene.instances) lamps += scene.prototypes[i.prototype].name == "lamp";
    ASSERT_GT(lamps, 20u);
    EXPECT_EQ(scene.facts().lights, lamps);
    EXPECT_LT(scene.sun.elevation, 0);
    for (const LocalLight& light : scene.lights) {
        // The lamp whose head it hangs from: its lowest point over the middle of the cone's axis.
        float head = 1e9f;
        for (const Instance& i : scene.instances) {
            const Prototype& p = scene.prototypes[i.prototype];
            if (p.name != "lamp" || glm::distance(glm::vec2(i.translation), glm::vec2(light.position)) > 2) continue;
            const float c = std::cos(i.yaw), s = std::sin(i.yaw);
            for (const Mesh& m : p.meshes)
                for (const glm::vec3& v : m.positions) {
                    const glm::vec3 w = i.translation + glm::vec3(c * v.x - s * v.y, s * v.x + c * v.y, v.z);
                    if (glm::distance(glm::vec2(w), glm::vec2(light.position)) < 0.4f) head = std::min(head, w.z);
                }
        }
        ASSERT_GT(head, light.position.z) << "no lamp shades its own light";
        ASSERT_LT(head, light.position.z + 0.1f);
        EXPECT_EQ(light.direction, glm::vec3(0, 0, -1));
        // KHR_lights_punctual: intensity / d², windowed by 1 - (d / range)⁴.
        const double d = double(light.position.z) - 0.15, window = 1 - std::pow(d / double(light.range), 4);
        const double lit = glm::dot(glm::dvec3(light.intensity), glm::dvec3(0.2126, 0.7152, 0.0722)) / (d * d) * window;
        EXPECT_GT(lit, 0.3);
        EXPECT_LT(lit, 0.5);
    }
    EXPECT_EQ(loadScene("city-vienna", {"scale=0.05"}).facts().lights, 0u);
    EXPECT_EQ(loadScene("city-vienna", {"scale=0.05", "city.traffic=0"}).facts().moving, false);
    EXPECT_GT(loadScene("city-vienna-night", {"scale=0.05"}).facts().lights, 20u);
}

/// Half sides of a box about a point, turned: for the separating axes of two rectangles.
struct Box2 {
    glm::dvec2 centre, axis, half;
};

bool overlap(const Box2& a, const Box2& b) {
    for (const Box2* r : {&a, &b})
        for (const glm::dvec2 n : {r->axis, glm::dvec2(-r->axis.y, r->axis.x)}) {
            const auto reach = [&](const Box2& q) { return std::abs(glm::dot(n, q.axis)) * q.half.x + std::abs(n.x * -q.axis.y + n.y * q.axis.x) * q.half.y; };
            if (std::abs(glm::dot(n, b.centre - a.centre)) > reach(a) + reach(b)) return false;
        }
    return true;
}

/// Of a car 4.4 m long and 1.76 m wide.
Box2 boxOf(const Motion::Pose& pose) { return {glm::dvec2(pose.translation), {std::cos(double(pose.yaw)), std::sin(double(pose.yaw))}, {2.2, 0.88}}; }

/// The cars that drive, by the way that they share.
std::map<std::array<float, 6>, std::vector<const Motion*>> loopsOf(const Scene& scene) {
    std::map<std::array<float, 6>, std::vector<const Motion*>> loops;
    for (const Motion& m : scene.motions) loops[{m.from.x, m.from.y, m.to.x, m.to.y, m.across, m.radius}].push_back(&m);
    return loops;
}

TEST_P(EveryCity, carsOfALoopNeverMeet) {
    for (const char* seed : {"1", "2", "3"}) {
        const Scene scene = loadScene(GetParam(), {"scale=0.05", "city.traffic=60", std::string("seed=") + seed});
        ASSERT_GT(scene.motions.size(), 40u);
        EXPECT_TRUE(scene.facts().moving);
        size_t shared = 0;
        for (const auto& [way, cars] : loopsOf(scene)) {
            const double lap = cars[0]->lap();
            shared += cars.size() > 1;
            for (double t = 0; t < 200; t += 3.7)
                for (size_t i = 0; i < cars.size(); ++i)
                    for (size_t k = 0; k < i; ++k) {
                        ASSERT_EQ(cars[i]->speed, cars[k]->speed);
                        const double apart = std::abs(double(cars[i]->start) - double(cars[k]->start));
                        ASSERT_GT(std::min(apart, lap - apart), 4.44 + 6 - 1e-3) << "a car's length and a gap, round the end too";
                        ASSERT_FALSE(overlap(boxOf(cars[i]->at(t)), boxOf(cars[k]->at(t))));
                    }
        }
        EXPECT_GT(shared, 5u);
        const Scene later = loadScene(GetParam(), {"scale=0.05", "city.traffic=60", std::string("seed=") + seed, "time=7.5"});
        for (const Motion& m : scene.motions) ASSERT_EQ(later.instances[m.instance].translation, m.at(7.5).translation);
    }
}

TEST_P(EveryCity, carsNeverJump) {
    // As they stand in the scene: over three laps no car moves or turns farther than its speed and its radius let it, or sideways.
    const Scene scene = loadScene(GetParam(), {"scale=0.1"});
    ASSERT_GT(scene.motions.size(), 10u);
    for (const Motion& m : scene.motions) {
        EXPECT_GE(m.speed, 8);
        EXPECT_LE(m.speed, 14);
        EXPECT_GE(m.radius, 2.9);
        constexpr double dt = 0.02;
        const double step = double(m.speed) * dt;
        Motion::Pose before = m.at(0);
        for (double t = dt; t * double(m.speed) < 3 * m.lap(); t += dt) {
            const Motion::Pose now = m.at(t);
            const glm::dvec2 moved = glm::dvec2(now.translation) - glm::dvec2(before.translation);
            ASSERT_LE(glm::length(moved), step + 1e-3);
            ASSERT_GE(std::cos(double(now.yaw) - double(before.yaw)), std::cos(step / double(m.radius) + 1e-3));
            const double yaw = double(before.yaw) + 0.5 * std::remainder(double(now.yaw) - double(before.yaw), 2 * M_PI);
            ASSERT_GT(std::cos(yaw) * moved.x + std::sin(yaw) * moved.y, 0.99 * step - 1e-3);
            before = now;
        }
    }
}

TEST_P(EveryCity, carsDriveClearOfWhatStandsInTheStreet) {
    const bool vienna = std::string(GetParam()) == "city-vienna";
    for (const uint64_t seed : {1, 2}) {
        const Scene scene = loadScene(GetParam(), {"scale=0.05", "city.traffic=60", "seed=" + std::to_string(seed)});
        const city::Plan plan = city::layOut(vienna ? city::Style::vienna : city::Style::manhattan, 0.05 * (vienna ? 0.9e6 : 7.7e6), seed);
        std::set<uint32_t> driving;
        for (const Motion& m : scene.motions) driving.insert(m.instance);
        std::vector<std::pair<std::string, Box2>> obstacles;
        for (uint32_t k = 0; k < scene.instances.size(); ++k) {
            const Instance& i = scene.instances[k];
            const Prototype& p = scene.prototypes[i.prototype];
            if (driving.contains(k) || !(p.name.starts_with("car") || p.name == "lamp" || p.name == "sign" || p.name.starts_with("tower"))) continue;
            // A lamp's arm hangs over the roadway, higher than any car: its post alone stands in the way.
            const dapple::base::Box box = p.box();
            const glm::dvec2 lo = p.name == "lamp" ? glm::dvec2(-0.14) : glm::dvec2(box.lo), hi = p.name == "lamp" ? glm::dvec2(0.14) : glm::dvec2(box.hi);
            const glm::dvec2 u(std::cos(double(i.yaw)), std::sin(double(i.yaw))), m = 0.5 * (lo + hi);
            obstacles.push_back({p.name, {glm::dvec2(i.translation) + m.x * u + m.y * glm::dvec2(-u.y, u.x), u, 0.5 * (hi - lo)}});
        }
        ASSERT_GT(obstacles.size(), 100u);
        for (const auto& [way, cars] : loopsOf(scene))
            for (double s = 0; s < cars[0]->lap(); s += 0.5) {
                const Box2 car = boxOf(cars[0]->at((s - double(cars[0]->start)) / double(cars[0]->speed)));
                for (const auto& [name, box] : obstacles) ASSERT_FALSE(glm::distance(box.centre, car.centre) < 60 && overlap(car, box)) << name;
                const glm::dvec2 across(-car.axis.y, car.axis.x);
                for (const double x : {-1.0, 0.0, 1.0})
                    for (const double y : {-1.0, 1.0})
                        for (const city::Block& block : plan.blocks) ASSERT_FALSE(block.kerb.contains(car.centre + x * car.half.x * car.axis + y * car.half.y * across)) << "a car on the pavement";
            }
    }
}

TEST_P(EveryCity, housesFarFromEveryViewArePlainerAndOtherwiseTheSame) {
    const std::vector<std::string> settings{"scale=0.06", "city.views=2"};
    const Scene fine = loadScene(GetParam(), settings), plain = loadScene(GetParam(), {settings[0], settings[1], "city.nearDetail=90"});
    ASSERT_EQ(fine.instances.size(), plain.instances.size());
    size_t coarser = 0, before = 0, after = 0;
    for (size_t k = 0; k < fine.instances.size(); ++k) {
        const Instance &a = fine.instances[k], &b = plain.instances[k];
        ASSERT_EQ(a.translation, b.translation);
        ASSERT_EQ(a.yaw, b.yaw);
        const Prototype &p = fine.prototypes[a.prototype], &q = plain.prototypes[b.prototype];
        ASSERT_EQ(p.name, q.name);
        ASSERT_EQ(p.closed, q.closed);
        if (p.name.starts_with("street tree") ? p.triangles() <= 500 : !p.name.starts_with("bay") && !p.name.starts_with("balcony") && !p.name.starts_with("tower")) continue;
        double distance = 1e300;
        for (const View& v : fine.views) distance = std::min(distance, glm::distance(v.eye, glm::dvec3(a.translation)));
        if (distance > 90 + 1e-3) {
            EXPECT_LT(q.triangles(), p.triangles()) << p.name;
            coarser += 1, before += p.triangles(), after += q.triangles();
        } else if (distance < 90 - 1e-3) {
            EXPECT_EQ(q.triangles(), p.triangles()) << p.name;
        }
        if (p.name.starts_with("balcony") || p.name.starts_with("street tree")) continue;
        // Walls, setbacks and roofs stay: the box loses what stands out of the facade, at most a cornice or a canopy.
        const dapple::base::Box x = p.box(), y = q.box();
        EXPECT_NEAR(x.hi.z, y.hi.z, 0.005f) << p.name;
        EXPECT_NEAR(x.lo.z, y.lo.z, 0.005f) << p.name;
        EXPECT_LT(glm::length(glm::vec2(x.size()) - glm::vec2(y.size())), 2.5f) << p.name;
    }
    EXPECT_GT(coarser, 20u);
    EXPECT_LT(double(after), 0.5 * double(before));
}

TEST_P(EveryCity, noBuildingCrossesAStreetOrANeighbour) {
    // By winding numbers about points of roadways and of the whole ground, in the built scene.
    const bool vienna = std::string(GetParam()) == "city-vienna";
    for (const uint64_t seed : {1, 2, 3}) {
        const Scene scene = load("0.03", std::to_string(seed));
        const city::Plan plan = city::layOut(vienna ? city::Style::vienna : city::Style::manhattan, 0.03 * (vienna ? 0.9e6 : 7.7e6), seed);
        std::vector<std::pair<const Instance*, dapple::base::Box>> buildings;
        for (const Instance& i : scene.instances) {
            const std::string& name = scene.prototypes[i.prototype].name;
            if (name.starts_with("block") || name.starts_with("tower")) buildings.emplace_back(&i, instanceBox(scene.prototypes[i.prototype].box(), i));
        }
        const auto owners = [&](const glm::dvec3& p) {
            int count = 0;
            for (const auto& [i, box] : buildings) {
                if (glm::any(glm::lessThan(p, glm::dvec3(box.lo))) || glm::any(glm::greaterThan(p, glm::dvec3(box.hi)))) continue;
                const double c = std::cos(double(i->yaw)), s = std::sin(double(i->yaw));
                const glm::dvec3 d = p - glm::dvec3(i->translation), local(c * d.x + s * d.y, c * d.y - s * d.x, d.z);
                int winding = 0;
                for (const Mesh& m : scene.prototypes[i->prototype].meshes) winding += windingNumber(m, local) > 0;
                count += winding > 0;
            }
            return count;
        };
        for (const city::Street& s : plan.streets) {
            const glm::dvec2 u = glm::normalize(s.b - s.a), left(-u.y, u.x);
            for (double x = s.width; x < glm::distance(s.a, s.b) - s.width; x += 7.3)
                for (const double across : {-0.49, -0.2, 0.0, 0.3, 0.49})
                    for (const double z : {1.01, 5.03, 9.07}) ASSERT_EQ(owners({s.a + x * u + across * s.width * left, z}), 0) << "a building stands in a street";
        }
        int built = 0;
        dapple::base::Box box;
        for (const glm::dvec2& p : plan.ground.corners) box.extend({p, 0});
        for (uint64_t k = 0; k < 1500; ++k) {
            const dapple::base::Random random(seed, k, 99);
            const glm::dvec3 p(random.uniform(0, box.lo.x, box.hi.x), random.uniform(1, box.lo.y, box.hi.y), 3.37);
            const int here = owners(p);
            ASSERT_LE(here, 1) << "two buildings in one place";
            built += here;
        }
        EXPECT_GT(built, 100);
    }
}

/// Taken from g++ 12 at -O2 and clang++ 14 at -O0, which agree.
TEST(City, recipesGiveTheSameBytesEverywhere) {
    for (const auto& [name, hash] : {std::pair("city-vienna", "3ab3d8ce90dfdefd"), {"city-manhattan", "fa2f817f759dc835"}})
        EXPECT_EQ(dapple::base::hex16(loadScene(name, {"scale=0.1"}).contentHash()), hash) << name;
}

INSTANTIATE_TEST_SUITE_P(Styles, EveryCity, testing::Values("city-vienna", "city-manhattan"), [](const auto& test) { return std::string(test.param).substr(5); });

TEST(City, viennaHasTwelveMillionTriangles) { EXPECT_NEAR(double(loadScene("city-vienna").facts().triangles), 12e6, 1.2e6); }

TEST(City, manhattanHasAHundredMillionTrianglesInLittleMemory) {
    const Scene scene = loadScene("city-manhattan");
    const Facts f = scene.facts();
    EXPECT_NEAR(double(f.triangles), 100e6, 10e6);
    size_t bytes = scene.instances.size() * sizeof(Instance);
    for (const Prototype& p : scene.prototypes)
        for (const Mesh& m : p.meshes) bytes += m.positions.size() * 24 + m.indices.size() * 4;
    EXPECT_LT(double(bytes), 2.0 * (1u << 30));
    EXPECT_LT(double(bytes) / double(f.triangles), 16);
}

TEST(City, badValuesNameFileLineAndKey) {
    EXPECT_THAT(errorOf("style = \"paris\"\n"), HasSubstr(".toml:3: style: 'paris' is none of vienna, manhattan"));
    EXPECT_THAT(errorOf("scale = 0\n"), HasSubstr("unknown key 'scale'"));  // it is the recipe's
    EXPECT_THROW(loadScene("city-vienna", {"scale=0.0001"}), dapple::base::UsageError);
    EXPECT_THAT(errorOf("views = 0\n"), HasSubstr(":3: views: 0 is outside"));
    EXPECT_THAT(errorOf("stile = \"vienna\"\n"), HasSubstr("did you mean 'style'?"));
}
