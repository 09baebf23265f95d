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

double leavesOf(const Species& species, const Stem& stem, LeafMode mode) {
    if (stem.level + 1 != int(species.levels.size())) return 0;
    const double leaves = species.leaves.count * stem.leafShare * (stem.length - stem.start) / stem.length;
    return mode == LeafMode::card ? leaves / species.leaves.cardLeaves : leaves;
}

struct Blade {
    glm::dvec3 root, along, across, normal;  // a right-handed frame: across × along = normal
    double length, width;
};

void addVertex(Mesh& mesh, const glm::dvec3& p, const glm::dvec3& n) {
    mesh.positions.push_back(glm::vec3(p));
    mesh.normals.push_back(glm::vec3(glm::normalize(n)));
}

void addLeaf(Mesh& mesh, const Blade& b) {
    const auto base = uint32_t(mesh.positions.size());
    const glm::dvec3 middle = b.root + b.along * (0.45 * b.length) + b.normal * (0.12 * b.width), side = b.across * (0.5 * b.width);
    addVertex(mesh, b.root, b.normal);
    addVertex(mesh, middle + side, b.normal - 0.4 * b.across);
    addVertex(mesh, b.root + b.along * b.length, b.normal);
    addVertex(mesh, middle - side, b.normal + 0.4 * b.across);
    for (const uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) mesh.indices.push_back(base + i);
}

void addCard(Mesh& mesh, const Blade& b) {
    const auto base = uint32_t(mesh.positions.size());
    const glm::dvec3 side = b.across * (0.5 * b.width), tip = b.root + b.along * b.length;
    for (const glm::dvec3& p : {b.root - side, b.root + side, tip + side, tip - side}) addVertex(mesh, p, b.normal);
    for (const glm::vec2 uv : {glm::vec2(0, 1), glm::vec2(1, 1), glm::vec2(1, 0), glm::vec2(0, 0)}) mesh.uvs.push_back(uv);
    for (const uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) mesh.indices.push_back(base + i);
}

/// Leaf k of n on a twig.
Blade placeBlade(const LeafParameters& p, const Stem& twig, LeafMode mode, size_t k, size_t n, double growth, base::Random& random) {
    const bool card = mode == LeafMode::card;
    const double share = n == 1 ? 0.6 : 0.12 + 0.86 * (double(k) + random.next(0.2f, 0.8f)) / double(n);
    const StemPoint at = twig.at(twig.start + (twig.length - twig.start) * share);
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

    const glm::dvec3 chance(random.next(-1, 1), random.next(-1, 1), random.next(-1, 1));
    glm::dvec3 wanted = chance * (1 - p.flat) + glm::dvec3(0, 0, 1) * p.flat + 0.2 * out;
    wanted -= along * glm::dot(wanted, along);
    if (glm::dot(wanted, wanted) < 1e-6) wanted = at.frame[1] - along * glm::dot(at.frame[1], along);
    if (glm::dot(wanted, wanted) < 1e-6) wanted = at.frame[0] - along * glm::dot(at.frame[0], along);
    const glm::dvec3 normal = glm::normalize(wanted);
    const double length = (card ? p.cardScale : p.scale) * growth * (1 + 0.2 * random.next(-1, 1));
    return {at.centre, along, glm::cross(along, normal), normal, length, length * (card ? p.cardScaleX : p.scaleX)};
}

}  // namespace

size_t naturalLeaves(const Species& species, const Skeleton& skeleton, std::span<const uint32_t> stems, LeafMode mode) {
    double sum = 0;
    for (const uint32_t i : stems) sum += leavesOf(species, skeleton.stems[i], mode);
    return size_t(sum + 0.5);
}

Mesh buildLeaves(const Species& species, const Skeleton& skeleton, std::span<const uint32_t> stems, LeafMode mode,
                 size_t count, uint64_t seed) {
    double natural = 0, wanted = 0;
    for (const Stem& stem : skeleton.stems) wanted += leavesOf(species, stem, mode);
    for (const uint32_t i : stems) natural += leavesOf(species, skeleton.stems[i], mode);
    Mesh mesh;
    if (natural <= 0 || count == 0) return mesh;
    mesh.positions.reserve(4 * count);
    mesh.normals.reserve(4 * count);
    mesh.indices.reserve(6 * count);
    if (mode == LeafMode::card) mesh.uvs.reserve(4 * count);

    const double growth = std::clamp(std::sqrt(wanted / double(count)), kMinGrowth, kMaxGrowth);
    double share = 0;
    size_t placed = 0;
    for (const uint32_t i : stems) {
        const Stem& stem = skeleton.stems[i];
        share += leavesOf(species, stem, mode);
        const size_t upTo = i == stems.back() ? count : std::min(count, size_t(share / natural * double(count) + 0.5));
        base::Random random(seed, i, kLeafPurpose);
        for (size_t k = 0, n = upTo - placed; k < n; ++k) {
            const Blade blade = placeBlade(species.leaves, stem, mode, k, n, growth, random);
            mode == LeafMode::card ? addCard(mesh, blade) : addLeaf(mesh, blade);
        }
        placed = upTo;
    }
    return mesh;
}

}  // namespace dapple::scenegen
