#include "bench/stress.h"

#include "base/error.h"
#include "scenegen/library.h"

#include <array>
#include <limits>
#include <vector>

namespace dapple::bench {
namespace {

using scenegen::Scene;
using scenegen::View;

/// Every view looks along `forward`, tilted from it by `radians` about a horizontal axis.
void lookAlong(Scene& scene, const glm::dvec3& forward, double radians) {
    const glm::dvec3 helper = std::abs(forward.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0);
    const glm::dvec3 side = glm::normalize(glm::cross(forward, helper));
    const glm::dvec3 up = glm::cross(side, forward);
    for (View& view : scene.views) {
        view.forward = glm::normalize(std::cos(radians) * forward + std::sin(radians) * up);
        view.up = glm::cross(side, view.forward);
    }
}

template <int degrees>
void sunAt(Scene& scene) { scene.sun.elevation = degrees; }

/// Light and view enclose 10^-exponent radians; exponent 0 stands for exactly parallel.
template <int exponent>
void parallel(Scene& scene) {
    // A high sun keeps receivers in the picture: the camera looks down along the light.
    scene.sun.elevation = std::max(scene.sun.elevation, 40.0);
    lookAlong(scene, scene.sun.direction(), exponent == 0 ? 0.0 : std::pow(10.0, -exponent));
}

void duelling(Scene& scene) {
    scene.sun.elevation = 15;  // low, so that a camera that looks into the sun still sees ground below the horizon
    lookAlong(scene, -scene.sun.direction(), 0);
}

template <int nearExponent, int farExponent>
void depthRange(Scene& scene) {
    for (View& view : scene.views) {
        view.near = std::pow(10.0, nearExponent);
        view.far = std::pow(10.0, farExponent);
    }
}

void noCaster(Scene& scene) {
    for (scenegen::Prototype& prototype : scene.prototypes) prototype.castsShadow = false;
}

void noReceiver(Scene& scene) {
    const float top = scene.facts().box.hi.z;
    for (View& view : scene.views) {
        view.eye.z = std::isfinite(top) ? static_cast<double>(top) + 10 : 10;
        view.forward = {0, 0, 1};
        view.up = {0, 1, 0};
    }
}

void farOrigin(Scene& scene) { scene.origin += glm::dvec3(1e6, -1e6, 0); }

/// Copies of the scene's last instance that can stand nowhere.
void badInstances(Scene& scene) {
    if (scene.instances.empty()) return;
    constexpr float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    const scenegen::Instance good = scene.instances.back();
    std::vector<scenegen::Instance> bad(7, good);
    bad[0].translation.x = nan;
    bad[1].translation.z = -inf;
    bad[2].scale = 0;
    bad[3].scale = -1;
    bad[4].scale = nan;
    bad[5].scale = 3e38f;
    bad[6].yaw = inf;
    // Before, between and behind the others: the order of the rest stays.
    scene.instances.insert(scene.instances.begin() + std::ptrdiff_t(scene.instances.size() / 2), bad.begin() + 2, bad.begin() + 4);
    scene.instances.insert(scene.instances.end(), bad.begin() + 4, bad.end());
    scene.instances.insert(scene.instances.begin(), bad.begin(), bad.begin() + 2);
    for (scenegen::Motion& m : scene.motions) m.instance += 2 + (m.instance >= (scene.instances.size() - 7) / 2 ? 2 : 0);
}

const std::array kCases = {
    StressCase{"none", "the scene as it is, for comparison", [](Scene&) {}},
    StressCase{"sun-zenith", "sun at the zenith: the light is the world's vertical", sunAt<90>},
    StressCase{"sun-1deg", "sun 1° above the horizon: shadows 57 times as long as their casters", sunAt<1>},
    StressCase{"sun-below", "sun 5° below the horizon: no direct light", sunAt<-5>},
    StressCase{"parallel-0", "light exactly parallel to the view", parallel<0>},
    StressCase{"parallel-1e-7", "light parallel to the view within 1e-7 rad", parallel<7>},
    StressCase{"parallel-1e-3", "light parallel to the view within 1e-3 rad", parallel<3>},
    StressCase{"duelling", "duelling frusta: the camera looks into the sun", duelling},
    StressCase{"depth-range", "near plane at 1e-3 m, far plane at 1e6 m", depthRange<-3, 6>},
    StressCase{"no-caster", "nothing casts a shadow", noCaster},
    StressCase{"no-receiver", "the camera sees only sky", noReceiver},
    StressCase{"bad-instances", "seven instances more, whose transforms are NaN, infinite, zero or mirrored: dropped and counted", badInstances},
    StressCase{"far-origin", "the scene is 1,414 km from the origin", farOrigin},
};

}  // namespace

std::span<const StressCase> stressCases() { return kCases; }

const StressCase& stressCase(const std::string& name) {
    std::vector<std::string> names;
    for (const StressCase& c : kCases) {
        if (c.name == name) return c;
        names.push_back(c.name);
    }
    throw base::UsageError(base::unknownName("stress case", name, names));
}

scenegen::Scene loadScene(const std::string& nameOrFile, const std::vector<std::string>& settings,
                          const std::string& stress) {
    Scene scene = scenegen::loadScene(nameOrFile, settings);
    if (stress.empty()) return scene;
    stressCase(stress).apply(scene);
    scenegen::dropBadInstances(scene);
    scenegen::validate(scene);
    return scene;
}

}  // namespace dapple::bench
