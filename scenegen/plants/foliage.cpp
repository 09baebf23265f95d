#include "scenegen/plants/foliage.h"

#include "base/detmath.h"
#include "base/random.h"

#include <algorithm>
#include <cmath>

namespace dapple::scenegen {
namespace det = base::det;
namespace {

constexpr uint64_t kLeafPurpose = 64;
/// Beyond these, leaves would no longer look like leaves.
constexpr double kMinGrowth = 0.5, kMaxGrowth = 3.5;

/// Where the leaves of one twig grow: on the twig, or, when the mesh leaves it out, on its parent where it began.
struct Site {
    uint32_t twig;
    const Stem* stem;
    const Stem* missingTwig;  ///< whose direction the leaves keep; null when `stem` is the twig
    double begin, end;  ///< offsets on `stem`
    double leaves;      ///< that the parameters ask for
    double size;        ///< of its leaves, relative
};

std::vector<Site> leafSites(const Species& species, const Skeleton& skeleton, std::span<const uint32_t> kept, LeafMode mode) {
    std::vector<bool> meshed(skeleton.stems.size(), false);
    for (const uint32_t i : kept) meshed[i] = true;
    double longest = 0, sum = 0, twigs = 0;
    for (const Stem& stem : skeleton.stems) {
        if (stem.level + 1 != int(species.levels.size())) continue;
        longest = std::max(longest, stem.length);
        sum += stem.length;
        twigs += 1;
    }
    std::vector<Site> sites;
    for (uint32_t i = 0; i < skeleton.stems.size(); ++i) {
        const Stem& twig = skeleton.stems[i];
        if (twig.level + 1 != int(species.levels.size())) continue;
        const double length = twig.length - twig.start;
        // The paper gives all twigs the same number; ours share out by length, or a fir's top would be its densest part.
        double leaves = species.leaves.count * twig.leafShare * length * twigs / sum;
        if (mode == LeafMode::card) leaves /= species.leaves.cardLeaves;
        const double size = mode == LeafMode::card ? 0.4 + 0.6 * twig.length / longest : 1;
        if (meshed[i]) {
            sites.push_back({i, &twig, nullptr, twig.start + 0.12 * length, twig.start + 0.98 * length, leaves, size});
        } else if (meshed[size_t(twig.parent)]) {
            const Stem& parent = skeleton.stems[size_t(twig.parent)];
            const double reach = 0.04 * parent.length;
            sites.push_back({i, &parent, &twig, std::max(parent.start, twig.parentOffset - reach),
                             std::min(0.98 * parent.length, twig.parentOffset + reach), leaves, size});
        }
    }
    return sites;
}

struct Blade {
    glm::dvec3 root, along, across, normal;  // a right-handed frame: across × along = normal
    double length, width;
};

/// The four corners of blade `at` and its two triangles (0, 1, 2) and (0, 2, 3).
void setBlade(Mesh& mesh, size_t at, const glm::dvec3 (&positions)[4], const glm::dvec3 (&normals)[4]) {
    for (size_t i = 0; i < 4; ++i) {
        mesh.positions[4 * at + i] = glm::vec3(positions[i]);
        mesh.normals[4 * at + i] = glm::vec3(normals[i]);
    }
    uint32_t* index = &mesh.indices[6 * at];
    for (const uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) *index++ = uint32_t(4 * at) + i;
}

void setLeaf(Mesh& mesh, size_t at, const Blade& b) {
    const glm::dvec3 middle = b.root + b.along * (0.45 * b.length) + b.normal * (0.12 * b.width), side = b.across * (0.5 * b.width);
    // The halves lean towards the midrib: normals 0.96² + 0.28² = 1.
    const glm::dvec3 up = 0.96 * b.normal, lean = 0.28 * b.across;
    setBlade(mesh, at, {b.root, middle + side, b.root + b.along * b.length, middle - side}, {b.normal, up - lean, b.normal, up + lean});
}

void setCard(Mesh& mesh, size_t at, const Blade& b) {
    const glm::dvec3 side = b.across * (0.5 * b.width), tip = b.root + b.along * b.length;
    setBlade(mesh, at, {b.root - side, b.root + side, tip + side, tip - side}, {b.normal, b.normal, b.normal, b.normal});
    const glm::vec2 uvs[4] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    std::copy_n(uvs, 4, &mesh.uvs[4 * at]);
}

/// Leaf k of n at a site.
Blade placeBlade(const LeafParameters& p, const Site& site, LeafMode mode, size_t k, size_t n, double growth, base::Random& random) {
    const bool card = mode == LeafMode::card;
    const double share = (double(k) + random.next(0.2f, 0.8f)) / double(n);
    StemPoint at = site.stem->at(site.begin + (site.end - site.begin) * share);
    if (site.missingTwig) at.frame = site.missingTwig->rings.front().frame;
    // Two rows (rotate < 0) or a helix, like the stems themselves.
    const double turn = p.rotate < 0 ? (k % 2 ? 90 : -90) : p.rotate * double(k);
    const double downAngle = card ? p.cardDownAngle : p.downAngle;
    // Towards the tip leaves close up: the last one goes on where the twig ends.
    const double down = std::max(0.0, downAngle * (1.15 - 0.6 * share) + p.downAngleV * random.next(-1, 1)) * det::kDegree;
    const double spin = (turn + p.rotateV * random.next(-1, 1)) * det::kDegree;
    const auto [ss, cs] = det::sinCos(spin);
    const auto [sd, cd] = det::sinCos(down);
    const glm::dvec3 out = at.frame[0] * cs + at.frame[1] * ss;
    const glm::dvec3 along = glm::normalize(at.frame[2] * cd + out * sd);

    const glm::dvec3 chance{random.next(-1, 1), random.next(-1, 1), random.next(-1, 1)};  // braces: drawn in this order
    glm::dvec3 wanted = chance * (1 - p.flat) + glm::dvec3(0, 0, 1) * p.flat + 0.2 * out;
    wanted -= along * glm::dot(wanted, along);
    if (glm::dot(wanted, wanted) < 1e-6) wanted = at.frame[1] - along * glm::dot(at.frame[1], along);
    if (glm::dot(wanted, wanted) < 1e-6) wanted = at.frame[0] - along * glm::dot(at.frame[0], along);
    const glm::dvec3 normal = glm::normalize(wanted);
    const double length = (card ? p.cardScale : p.scale) * site.size * growth * (1 + 0.2 * random.next(-1, 1));
    return {at.centre, along, glm::cross(along, normal), normal, length, length * (card ? p.cardScaleX : p.scaleX)};
}

}  // namespace

size_t naturalLeaves(const Species& species, const Skeleton& skeleton, std::span<const uint32_t> kept, LeafMode mode) {
    double sum = 0;
    for (const Site& site : leafSites(species, skeleton, kept, mode)) sum += site.leaves;
    return size_t(sum + 0.5);
}

Mesh buildLeaves(const Species& species, const Skeleton& skeleton, std::span<const uint32_t> kept, LeafMode mode,
                 size_t count, uint64_t seed) {
    const std::vector<Site> sites = leafSites(species, skeleton, kept, mode);
    double available = 0;
    for (const Site& site : sites) available += site.leaves;
    Mesh mesh;
    if (available <= 0 || count == 0) return mesh;
    mesh.positions.resize(4 * count);
    mesh.normals.resize(4 * count);
    mesh.indices.resize(6 * count);
    if (mode == LeafMode::card) mesh.uvs.resize(4 * count);

    const double growth = std::clamp(std::sqrt(available / double(count)), kMinGrowth, kMaxGrowth);
    double share = 0;
    size_t placed = 0;
    for (const Site& site : sites) {
        share += site.leaves;
        const size_t upTo = &site == &sites.back() ? count : std::min(count, size_t(share / available * double(count) + 0.5));
        base::Random random(seed, site.twig, kLeafPurpose);
        for (size_t k = 0, n = upTo - placed; k < n; ++k) {
            const Blade blade = placeBlade(species.leaves, site, mode, k, n, growth, random);
            mode == LeafMode::card ? setCard(mesh, placed + k, blade) : setLeaf(mesh, placed + k, blade);
        }
        placed = upTo;
    }
    return mesh;
}

}  // namespace dapple::scenegen
