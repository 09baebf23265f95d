#include "scenegen/plants/foliage.h"

#include "base/detmath.h"
#include "base/random.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace dapple::scenegen {
namespace det = base::det;
namespace {

constexpr uint64_t kLeafPurpose = 64;
/// Times its size that a leaf may shrink or grow: near by it must look like a leaf, far away like a bough.
constexpr double kMinGrowth = 0.5, kMaxGrowth[kLods] = {3.5, 6, 12};
/// Least width over length of the farthest level's leaves: a bundle of needles is no giant needle.
constexpr double kFarScaleX = 0.4;
/// Thickness of a solid leaf over its width: far more than a real one's, so that depth maps can tell its sides apart.
constexpr double kThickness = 0.04;

struct Blade {
    glm::dvec3 root, along, across, normal;  // a right-handed frame: across × along = normal
    double length, width;
};

/// The corners of a leaf: root, right, tip, left; the halves rise from the midrib.
struct Outline {
    glm::dvec3 positions[4], normals[4];
};

Outline leafOutline(const Blade& b) {
    const glm::dvec3 middle = b.root + b.along * (0.45 * b.length) + b.normal * (0.12 * b.width), side = b.across * (0.5 * b.width);
    // The halves lean towards the midrib: normals 0.96² + 0.28² = 1.
    const glm::dvec3 up = 0.96 * b.normal, lean = 0.28 * b.across;
    return {{b.root, middle + side, b.root + b.along * b.length, middle - side}, {b.normal, up - lean, b.normal, up + lean}};
}

/// Vertices and triangles of blade `at`; two triangles (0, 1, 2) and (0, 2, 3).
void setQuad(Mesh& mesh, size_t at, const Outline& o) {
    for (size_t i = 0; i < 4; ++i) {
        mesh.positions[4 * at + i] = glm::vec3(o.positions[i]);
        mesh.normals[4 * at + i] = glm::vec3(o.normals[i]);
    }
    uint32_t* index = &mesh.indices[6 * at];
    for (const uint32_t i : {0u, 1u, 2u, 0u, 2u, 3u}) *index++ = uint32_t(4 * at) + i;
}

/// An octahedron: the outline, and a point above and below its midrib. The rim stands twice, for normals of both sides.
void setSolid(Mesh& mesh, size_t at, const Blade& b) {
    const Outline o = leafOutline(b);
    const glm::dvec3 middle = b.root + b.along * (0.45 * b.length), thick = b.normal * (0.5 * kThickness * b.width);
    for (size_t below = 0; below < 2; ++below) {
        const double up = below ? -1 : 1;
        const size_t first = 10 * at + 5 * below;
        for (size_t i = 0; i < 4; ++i) {
            mesh.positions[first + i] = glm::vec3(o.positions[i]);
            mesh.normals[first + i] = glm::vec3(up * o.normals[i]);
        }
        mesh.positions[first + 4] = glm::vec3(middle + up * thick);
        mesh.normals[first + 4] = glm::vec3(up * b.normal);
    }
    uint32_t* index = &mesh.indices[24 * at];
    for (const uint32_t i : {0u, 1u, 4u, 1u, 2u, 4u, 2u, 3u, 4u, 3u, 0u, 4u, 6u, 5u, 9u, 7u, 6u, 9u, 8u, 7u, 9u, 5u, 8u, 9u})
        *index++ = uint32_t(10 * at) + i;
}

void setCard(Mesh& mesh, size_t at, const Blade& b) {
    const glm::dvec3 side = b.across * (0.5 * b.width), tip = b.root + b.along * b.length;
    setQuad(mesh, at, {{b.root - side, b.root + side, tip + side, tip - side}, {b.normal, b.normal, b.normal, b.normal}});
    const glm::vec2 uvs[4] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    std::copy_n(uvs, 4, &mesh.uvs[4 * at]);
}

/// Away from the trunk, where the light comes from; unit length but on the trunk's axis.
glm::dvec3 outward(const glm::dvec3& p) {
    const double distance = std::sqrt(p.x * p.x + p.y * p.y);
    return distance > 1e-6 ? glm::dvec3(p.x / distance, p.y / distance, 0) : glm::dvec3(0);
}

/// What chance and the parameters give to a leaf before its twig is looked at.
struct Draw {
    double share;          ///< place on the site, 0…1
    double spin, down;     ///< radians, about the twig and away from it
    glm::dvec3 chance;     ///< of the blade's side
    double length, width;  ///< metres
    double behind;         ///< of its root, metres: how far a leaf that stands for several reaches back
    det::SinCos spinSinCos, downSinCos;
};

/// Leaf k of n at a site.
Draw drawLeaf(const LeafParameters& p, const LeafSite& site, LeafMode mode, size_t k, size_t n, double growth, int lod, base::Random& random) {
    const bool card = mode == LeafMode::card;
    Draw d;
    d.share = (double(k) + random.next(0.2f, 0.8f)) / double(n);
    // Two rows (rotate < 0) or a helix, like the stems themselves.
    const double turn = p.rotate < 0 ? (k % 2 ? 90 : -90) : p.rotate * double(k);
    const double downAngle = card ? p.cardDownAngle : p.downAngle;
    // Towards the tip leaves close up: the last one goes on where the twig ends.
    d.down = std::max(0.0, downAngle * (1.15 - 0.6 * d.share) + p.downAngleV * random.next(-1, 1)) * det::kDegree;
    d.spin = (turn + p.rotateV * random.next(-1, 1)) * det::kDegree;
    d.chance = {random.next(-1, 1), random.next(-1, 1), random.next(-1, 1)};  // braces: drawn in this order
    d.length = (card ? p.cardScale : p.scale) * site.size * growth * (1 + 0.2 * random.next(-1, 1)) * (1 + (p.tipScale - 1) * d.share);
    d.width = d.length * (card ? p.cardScaleX : p.scaleX);
    if (lod == kLods - 1 && d.width < kFarScaleX * d.length) {
        d.length = std::sqrt(d.length * d.width / kFarScaleX);
        d.width = d.length * kFarScaleX;
    }
    d.behind = lod > 0 ? 0.5 * std::max(0.0, 1 - 1 / growth) * d.length : 0;
    return d;
}

Blade placeBlade(const LeafParameters& p, const Draw& d, const StemPoint& at) {
    const glm::dvec3 out = at.frame[0] * d.spinSinCos.cos + at.frame[1] * d.spinSinCos.sin;
    const glm::dvec3 along = glm::normalize(at.frame[2] * d.downSinCos.cos + out * d.downSinCos.sin);
    glm::dvec3 wanted = d.chance * (1 - p.flat) + glm::dvec3(0, 0, 1) * p.flat + 0.2 * out;
    if (p.bend > 0) wanted += p.bend * outward(at.centre);
    wanted -= along * glm::dot(wanted, along);
    if (glm::dot(wanted, wanted) < 1e-6) wanted = at.frame[1] - along * glm::dot(at.frame[1], along);
    if (glm::dot(wanted, wanted) < 1e-6) wanted = at.frame[0] - along * glm::dot(at.frame[0], along);
    const glm::dvec3 normal = glm::normalize(wanted);
    return {at.centre - d.behind * along, along, glm::cross(along, normal), normal, d.length, d.width};
}

void setBlade(Mesh& mesh, LeafMode mode, size_t at, const Blade& blade) {
    switch (mode) {
        case LeafMode::polygon: return setQuad(mesh, at, leafOutline(blade));
        case LeafMode::card: return setCard(mesh, at, blade);
        case LeafMode::solid: return setSolid(mesh, at, blade);
    }
}

/// Leaves 0 … n - 1 of a site, as blades first … first + n - 1 of the mesh. A leaf is one long chain of roots and
/// quotients that wait for each other; taken step by step for many leaves, the processor works on several at once.
void growSite(Mesh& mesh, const LeafParameters& p, const LeafSite& site, LeafMode mode, size_t first, size_t n, double growth, int lod, base::Random random) {
    constexpr size_t kBatch = 32;
    std::array<Draw, kBatch> draws;
    std::array<StemPoint, kBatch> points;
    StemAxis axis(*site.stem);
    for (size_t begin = 0; begin < n; begin += kBatch) {
        const size_t count = std::min(kBatch, n - begin);
        for (size_t i = 0; i < count; ++i) draws[i] = drawLeaf(p, site, mode, begin + i, n, growth, lod, random);
        for (size_t i = 0; i < count; ++i) {
            draws[i].spinSinCos = det::sinCos(draws[i].spin);
            draws[i].downSinCos = det::sinCos(draws[i].down);
        }
        for (size_t i = 0; i < count; ++i) {
            const double offset = site.begin + (site.end - site.begin) * draws[i].share;
            points[i] = site.missingTwig ? StemPoint{axis.centre(offset), site.missingTwig->rings.front().frame, 0} : axis.at(offset);
        }
        for (size_t i = 0; i < count; ++i) setBlade(mesh, mode, first + begin + i, placeBlade(p, draws[i], points[i]));
    }
}

}  // namespace

std::vector<LeafSite> leafSites(const Species& species, const Skeleton& skeleton, std::span<const uint32_t> kept,
                                LeafMode mode, bool floating) {
    std::vector<bool> meshed(skeleton.stems.size(), false);
    for (const uint32_t i : kept) meshed[i] = true;
    double longest = 0, sum = 0, twigs = 0;
    for (const Stem& stem : skeleton.stems) {
        if (stem.level + 1 != int(species.levels.size())) continue;
        longest = std::max(longest, stem.length);
        sum += stem.length;
        twigs += 1;
    }
    std::vector<LeafSite> sites;
    for (uint32_t i = 0; i < skeleton.stems.size(); ++i) {
        const Stem& twig = skeleton.stems[i];
        if (twig.level + 1 != int(species.levels.size())) continue;
        const double length = twig.length - twig.start;
        // The paper gives all twigs the same number; ours share out by length, or a fir's top would be its densest part.
        double leaves = species.leaves.count * twig.leafShare * length * twigs / sum;
        if (mode == LeafMode::card) leaves /= species.leaves.cardLeaves;
        const double size = mode == LeafMode::card ? 0.4 + 0.6 * twig.length / longest : 1;
        if (meshed[i] || floating) {
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

size_t naturalLeaves(std::span<const LeafSite> sites) {
    double sum = 0;
    for (const LeafSite& site : sites) sum += site.leaves;
    return size_t(sum + 0.5);
}

Mesh buildLeaves(const Species& species, std::span<const LeafSite> sites, LeafMode mode, size_t count, int lod, uint64_t seed) {
    double available = 0;
    for (const LeafSite& site : sites) available += site.leaves;
    Mesh mesh;
    if (available <= 0 || count == 0) return mesh;
    const size_t corners = mode == LeafMode::solid ? 10 : 4;
    mesh.positions.resize(corners * count);
    mesh.normals.resize(corners * count);
    mesh.indices.resize(3 * leafTriangles(mode) * count);
    if (mode == LeafMode::card) mesh.uvs.resize(corners * count);

    const double growth = std::clamp(std::sqrt(available / double(count)), kMinGrowth, kMaxGrowth[lod]);
    double share = 0;
    size_t placed = 0;
    for (const LeafSite& site : sites) {
        share += site.leaves;
        const size_t upTo = &site == &sites.back() ? count : std::min(count, size_t(share / available * double(count) + 0.5));
        growSite(mesh, species.leaves, site, mode, placed, upTo - placed, growth, lod, base::Random(seed, site.twig, kLeafPurpose));
        placed = upTo;
    }
    return mesh;
}

}  // namespace dapple::scenegen
