#include "scenegen/plants/foliage.h"

#include "base/detmath.h"
#include "base/random.h"
#include "scenegen/plants/lanes.h"

#include <algorithm>
#include <cmath>

namespace dapple::scenegen {
namespace det = base::det;
namespace {

constexpr uint64_t kLeafPurpose = 64;
/// Times its size that a leaf may shrink or grow: near by it must look like a leaf, far away like a bough.
constexpr double kMinGrowth = 0.5, kMaxGrowth[kLods] = {3.5, 6, 12};
/// Least width over length of the farthest level's leaves: a bundle of needles is no giant needle.
constexpr double kFarScaleX = 0.4;

/// Leaves on their way into a mesh. A leaf is one long chain of roots and quotients that wait for each other; taken step by
/// step for many leaves, in pairs, the processor works on several at once.
class LeafBatch {
public:
    LeafBatch(Mesh& mesh, const LeafParameters& p, LeafShape shape, LeafMode mode, double growth, int lod)
        : mesh_(mesh), p_(p), shape_(shape), mode_(mode), corners_(leafVertices(shape, mode)), indices_(3 * leafTriangles(shape, mode)), growth_(growth), lod_(lod) {
        block_.positions.resize(kSize * corners_);
        block_.normals.resize(kSize * corners_);
        block_.indices.resize(kSize * indices_);
        if (mode == LeafMode::card) block_.uvs.resize(kSize * corners_);
    }

    /// Leaves 0 … n - 1 of a site.
    void grow(const LeafSite& site, size_t n, base::Random random) {
        StemAxis axis(*site.stem);
        const glm::dmat3* twig = site.missingTwig ? &site.missingTwig->root : nullptr;
        for (size_t k = 0; k < n; ++k) {
            const double share = draw(site, k, n, random);
            const StemAxis::Raw at = axis.raw(site.begin + (site.end - site.begin) * share);
            centre_.set(count_, at.centre);
            z_.set(count_, at.along);
            x_.set(count_, at.across);
            twig_[count_] = twig;
            if (++count_ == kSize) flush();
        }
    }

    /// Those that wait.
    void flush() {
        orient();
        place();
        const auto first = uint32_t(mesh_.positions.size());
        for (size_t i = 0; i < count_; ++i)
            setLeaf(block_, shape_, mode_, i * corners_, i * indices_, first, {centre_.at(i), z_.at(i), x_.at(i), y_.at(i), length_.v[i], width_.v[i]});
        // Into reserved memory, which is not written twice.
        const auto append = [](auto& to, const auto& from, size_t n) { to.insert(to.end(), from.begin(), from.begin() + long(n)); };
        append(mesh_.positions, block_.positions, count_ * corners_);
        append(mesh_.normals, block_.normals, count_ * corners_);
        append(mesh_.indices, block_.indices, count_ * indices_);
        if (mode_ == LeafMode::card) append(mesh_.uvs, block_.uvs, count_ * corners_);
        count_ = 0;
    }

private:
    static constexpr size_t kSize = 64;

    struct Column {
        alignas(16) double v[kSize] = {};
        Pair pair(size_t i) const { return loadPair(v + i); }
    };
    struct Column3 {
        Column x, y, z;
        glm::dvec3 at(size_t i) const { return {x.v[i], y.v[i], z.v[i]}; }
        void set(size_t i, const glm::dvec3& p) { x.v[i] = p.x, y.v[i] = p.y, z.v[i] = p.z; }
        Pair3 pair(size_t i) const { return {x.pair(i), y.pair(i), z.pair(i)}; }
        void setPair(size_t i, const Pair3& p) { storePair(x.v + i, p.x), storePair(y.v + i, p.y), storePair(z.v + i, p.z); }
    };

    /// What chance and the parameters give to leaf k of n before its twig is looked at; returns its place on the site, 0…1.
    double draw(const LeafSite& site, size_t k, size_t n, base::Random& random) {
        const bool card = mode_ == LeafMode::card;
        const double share = (double(k) + random.next(0.2f, 0.8f)) / double(n);
        // Two rows (rotate < 0) or a helix, like the stems themselves; a fan lies in one plane.
        const double fan = (2 * double(k) + 1) / double(n) - 1;
        const bool rows = p_.rotate < 0 || p_.count < 0;
        const double turn = rows ? ((p_.count < 0 ? fan > 0 : k % 2) ? 90 : -90) : p_.rotate * double(k);
        const double downAngle = (card ? p_.cardDownAngle : p_.downAngle) * (p_.count < 0 ? std::abs(fan) : 1);
        // Towards the tip leaves close up: the last one goes on where the twig ends.
        down_.v[count_] = std::max(0.0, downAngle * (1.15 - 0.6 * share) + p_.downAngleV * random.next(-1, 1)) * det::kDegree;
        spin_.v[count_] = (turn + p_.rotateV * random.next(-1, 1)) * det::kDegree;
        chance_.set(count_, {random.next(-1, 1), random.next(-1, 1), random.next(-1, 1)});  // braces: drawn in this order
        double length = (card ? p_.cardScale : p_.scale) * site.size * growth_ * (1 + 0.2 * random.next(-1, 1)) * (1 + (p_.tipScale - 1) * share);
        double width = length * (card ? p_.cardScaleX : p_.scaleX);
        if (lod_ == kLods - 1 && width < kFarScaleX * length) {
            length = std::sqrt(length * width / kFarScaleX);
            width = length * kFarScaleX;
        }
        length_.v[count_] = length;
        width_.v[count_] = width;
        behind_.v[count_] = lod_ > 0 ? 0.5 * std::max(0.0, 1 - 1 / growth_) * length : 0;
        return share;
    }

    /// Orthonormal frames in x_, y_, z_.
    void orient() {
        for (size_t i = 0; i < count_; i += 2) {
            const Pair3 z = normalize(z_.pair(i)), x = x_.pair(i), across = normalize(x - z * dot(x, z));
            z_.setPair(i, z);
            x_.setPair(i, across);
            y_.setPair(i, cross(z, across));
        }
        for (size_t i = 0; i < count_; ++i)
            if (twig_[i]) x_.set(i, (*twig_[i])[0]), y_.set(i, (*twig_[i])[1]), z_.set(i, (*twig_[i])[2]);
    }

    /// Roots in centre_; along, across and normal in z_, x_ and y_.
    void place() {
        for (size_t i = 0; i < count_; i += 2) {
            const PairSinCos spin = sinCos(spin_.pair(i)), down = sinCos(down_.pair(i));
            const Pair3 x = x_.pair(i), y = y_.pair(i), centre = centre_.pair(i), out = x * spin.cos + y * spin.sin;
            const Pair3 along = normalize(z_.pair(i) * down.cos + out * down.sin);
            const Pair flat = Pair{1, 1} * p_.flat, random = 1.0 - flat;
            Pair3 wanted = chance_.pair(i) * random;
            wanted.z += flat;
            wanted = wanted + out * Pair{0.2, 0.2};
            if (p_.bend > 0) {
                // Away from the trunk, where the light comes from.
                const Pair toTrunk = squareRoot(centre.x * centre.x + centre.y * centre.y), distance = toTrunk > 1e-6 ? toTrunk : Pair{1, 1};
                wanted.x += p_.bend * (centre.x / distance);
                wanted.y += p_.bend * (centre.y / distance);
            }
            wanted = wanted - along * dot(wanted, along);
            wanted = sideways(wanted, along, y);
            wanted = sideways(wanted, along, x);
            const Pair3 normal = normalize(wanted);
            centre_.setPair(i, centre - along * behind_.pair(i));
            z_.setPair(i, along);
            x_.setPair(i, cross(along, normal));
            y_.setPair(i, normal);
        }
    }

    /// `wanted`, or where nothing is left of it, what of `instead` is across `along`.
    static Pair3 sideways(Pair3 wanted, const Pair3& along, const Pair3& instead) {
        const Pair size = dot(wanted, wanted);
        if (size[0] >= 1e-6 && size[1] >= 1e-6) return wanted;
        const Pair3 other = instead - along * dot(instead, along);
        for (int lane = 0; lane < 2; ++lane)
            if (!(size[lane] >= 1e-6)) wanted.x[lane] = other.x[lane], wanted.y[lane] = other.y[lane], wanted.z[lane] = other.z[lane];
        return wanted;
    }

    Mesh& mesh_;
    const LeafParameters& p_;
    LeafShape shape_;
    LeafMode mode_;
    size_t corners_, indices_;  // of one leaf
    double growth_;
    int lod_;
    Mesh block_;              // of those that wait, from where they go into the mesh together
    size_t count_ = 0;        // that wait
    Column spin_, down_;     // radians, about the twig and away from it
    Column length_, width_;  // metres
    Column behind_;          // of the root, metres: how far a leaf that stands for several reaches back
    Column3 chance_;         // of the blade's side
    Column3 centre_, x_, y_, z_;
    const glm::dmat3* twig_[kSize] = {};  // frame of a twig that is not meshed
};

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
        double leaves = std::abs(species.leaves.count) * twig.leafShare * length * twigs / sum;
        if (mode == LeafMode::card) leaves /= species.leaves.cardLeaves;
        const double size = mode == LeafMode::card ? 0.4 + 0.6 * twig.length / longest : 1;
        if (meshed[i] || floating) {
            const double begin = species.leaves.count < 0 ? 0.94 : 0.12;
            sites.push_back({i, &twig, nullptr, twig.start + begin * length, twig.start + 0.98 * length, leaves, size});
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
    const LeafShape shape = leafShape(species, lod);
    const size_t corners = leafVertices(shape, mode);
    mesh.positions.reserve(corners * count);
    mesh.normals.reserve(corners * count);
    mesh.indices.reserve(3 * leafTriangles(shape, mode) * count);
    if (mode == LeafMode::card) mesh.uvs.reserve(corners * count);

    const double far = lod > 0 && mode == LeafMode::card ? species.leaves.cardFar[size_t(lod) - 1] : 1;
    const double growth = far * std::clamp(std::sqrt(available / double(count)), kMinGrowth, kMaxGrowth[lod]);
    LeafBatch batch(mesh, species.leaves, shape, mode, growth, lod);
    double share = 0;
    size_t placed = 0;
    for (const LeafSite& site : sites) {
        share += site.leaves;
        const size_t upTo = &site == &sites.back() ? count : std::min(count, size_t(share / available * double(count) + 0.5));
        batch.grow(site, upTo - placed, base::Random(seed, site.twig, kLeafPurpose));
        placed = upTo;
    }
    batch.flush();
    return mesh;
}

}  // namespace dapple::scenegen
