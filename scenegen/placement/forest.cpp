#include "scenegen/placement/forest.h"

#include "base/detmath.h"
#include "base/random.h"

#include <algorithm>

namespace dapple::scenegen {
namespace {
constexpr uint64_t kPurpose = 0x74726565;
}

std::vector<Instance> plantForest(size_t trees, double spacing, Crowding crowding, uint64_t seed, std::span<const Stand> stands, const Site& site) {
    double shares = 0;
    for (const Stand& stand : stands) shares += stand.share;
    std::vector<double> due(stands.size(), 0), radii;
    std::vector<Instance> sown;
    std::vector<uint32_t> standOf;
    for (size_t i = 0; i < trees; ++i) {
        // Largest remainder: after n trees every species has its share to within one tree.
        for (size_t k = 0; k < due.size(); ++k) due[k] += stands[k].share / shares;
        const auto k = size_t(std::max_element(due.begin(), due.end()) - due.begin());
        due[k] -= 1;
        const Stand& stand = stands[k];
        base::Random random(seed, i, kPurpose);
        const auto individual = size_t(random.next() * float(stand.individuals.size()));
        Instance tree;
        tree.prototype = stand.individuals[individual];
        tree.yaw = float(2 * base::det::kPi * random.next());
        tree.scale = float(stand.scale.x + (stand.scale.y - stand.scale.x) * random.next());
        sown.push_back(tree);
        standOf.push_back(uint32_t(k));
        radii.push_back(spacing * stand.crownRadii[individual] * tree.scale);
    }
    const Disks places = poissonDisks(radii, site.half, seed, crowding, [&](size_t i, const glm::dvec2& p) {
        if (!site.open(p)) return false;
        const Stand& stand = stands[standOf[i]];
        if (stand.altitude.x > -1e300 || stand.altitude.y < 1e300) {
            const double z = site.height(p);
            if (z < stand.altitude.x || z > stand.altitude.y) return false;
        }
        return stand.steepest >= 1e300 || site.slope(p) <= stand.steepest;
    });
    std::vector<Instance> standing;
    standing.reserve(places.kept.size());
    for (size_t n = 0; n < places.kept.size(); ++n) {
        Instance tree = sown[places.kept[n]];
        tree.translation = glm::vec3(glm::dvec3(places.points[n], site.height(places.points[n])));
        standing.push_back(tree);
    }
    return standing;
}

}  // namespace dapple::scenegen
