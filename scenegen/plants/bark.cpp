#include "scenegen/plants/bark.h"

#include "base/detmath.h"
#include "scenegen/plants/tube.h"

#include <algorithm>
#include <map>
#include <tuple>

namespace dapple::scenegen {
namespace {

/// At each level of detail: steps of coarsening (from the third on, each halves the rings), and the share of the twigs
/// for whose sake other stems are coarsened.
constexpr int kCoarsest[kLods] = {3, 4, 5};
constexpr double kTwigShare[kLods] = {0.5, 0.2, 0};

/// Share of a scarce budget that stems other than twigs may use.
constexpr double kWoodShare = 0.92;

struct Cage {
    int sides, rings, refine;
    size_t triangles() const { return tubeTriangles(sides, rings, refine); }
};

Cage cageOf(const Species& species, const Stem& stem, int coarser) {
    const LevelParameters& p = species.levels[size_t(stem.level)];
    const int sides = coarser >= 4 ? 4 : coarser >= 2 ? std::max(4, p.sides / 4 * 2) : p.sides;
    return {sides, int(stem.ringCount), std::max(0, p.refine - coarser)};
}

/// Keeps share/of of the stems for which `candidate` holds, evenly, and of the others those whose parent is kept.
template <class Candidate>
std::vector<bool> thin(const Skeleton& skeleton, const std::vector<bool>& kept, size_t share, size_t of, Candidate candidate) {
    std::vector<bool> result = kept;
    size_t sum = 0;
    for (size_t i = 0; i < kept.size(); ++i) {
        const Stem& stem = skeleton.stems[i];
        if (stem.parent >= 0 && !result[size_t(stem.parent)]) result[i] = false;
        if (!result[i] || !candidate(stem)) continue;
        sum += share;
        result[i] = sum >= of;
        if (sum >= of) sum -= of;
    }
    return result;
}

/// A ring's polygon in its frame, of a surface of radius 1.
using Polygon = std::vector<glm::dvec2>;

Polygon ringPolygon(int sides, int lobes, double lobeDepth) {
    Polygon polygon;
    for (int k = 0; k < sides; ++k) {
        const double angle = 2 * base::det::kPi * k / sides;
        const auto [s, c] = base::det::sinCos(angle);
        polygon.push_back(glm::dvec2(c, s) * (cageScale(sides) * (1 + lobeDepth * base::det::sin(lobes * angle))));
    }
    return polygon;
}

/// Writes lane `lane` of the control points, [control][xyz][lane].
void writeControls(const Stem& stem, const Polygon& polygon, size_t lane, float* controls) {
    float* out = controls + lane;
    for (size_t i = 0; i < stem.rings.size(); ++i) {
        const Ring& ring = stem.rings[i];
        const glm::dvec3 centre = stem.cageCentre(i);
        const glm::dvec3 x = ring.frame[0] * ring.radius, y = ring.frame[1] * ring.radius;
        for (const glm::dvec2& corner : polygon) {
            const glm::dvec3 p = centre + x * corner.x + y * corner.y;
            for (int axis = 0; axis < 3; ++axis) out[axis * kLanes] = float(p[axis]);
            out += 3 * kLanes;
        }
    }
}

}  // namespace

BarkPlan planBark(const Species& species, Skeleton& skeleton, size_t budget, int lod) {
    const int twigLevel = int(species.levels.size()) - 1;
    const auto isTwig = [&](const Stem& s) { return s.level == twigLevel; };
    const auto isLimb = [&](const Stem& s) { return s.level > 0 && s.level < twigLevel; };
    int coarser = 0;
    std::vector<bool> kept(skeleton.stems.size(), true);
    size_t trunks = 0, limbs = 0, twigs = 0;
    const auto count = [&] {
        trunks = limbs = twigs = 0;
        const Stem* last = nullptr;
        size_t triangles = 0;
        for (size_t i = 0; i < kept.size(); ++i) {
            if (!kept[i]) continue;
            const Stem& stem = skeleton.stems[i];
            // Most stems are twigs of one kind.
            if (!last || !stem.isLike(*last)) triangles = cageOf(species, *(last = &stem), coarser).triangles();
            (isTwig(stem) ? twigs : isLimb(stem) ? limbs : trunks) += triangles;
        }
    };
    count();
    if (budget > 0) {
        const auto tooMany = [&] { return trunks + limbs + size_t(kTwigShare[lod] * double(twigs)) > budget; };
        while (coarser < kCoarsest[lod] && tooMany()) {
            if (++coarser >= 3) thinRings(skeleton);
            count();
        }
        const auto wood = size_t(kWoodShare * double(budget));
        if (tooMany() && trunks + limbs > wood) {
            kept = thin(skeleton, kept, wood > trunks ? wood - trunks : 0, std::max<size_t>(limbs, 1), isLimb);
            count();
        }
        if (trunks + limbs + twigs > budget) {
            const size_t left = budget > trunks + limbs ? budget - trunks - limbs : 0;
            kept = thin(skeleton, kept, std::min(left, twigs), std::max<size_t>(twigs, 1), isTwig);
            count();
        }
    }
    BarkPlan plan{coarser, {}, trunks + limbs + twigs};
    for (uint32_t i = 0; i < kept.size(); ++i)
        if (kept[i]) plan.kept.push_back(i);
    return plan;
}

Mesh buildBark(const Species& species, const Skeleton& skeleton, const BarkPlan& plan) {
    std::map<std::tuple<int, int, int>, std::vector<uint32_t>> groups;  // by topology
    const Stem* last = nullptr;
    std::vector<uint32_t>* group = nullptr;
    for (const uint32_t i : plan.kept) {
        const Stem& stem = skeleton.stems[i];
        if (!last || !stem.isLike(*last)) {
            const Cage cage = cageOf(species, *(last = &stem), plan.coarser);
            group = &groups[{cage.sides, cage.rings, cage.refine}];
        }
        group->push_back(i);
    }
    size_t vertices = 0, indices = 0, most = 0;
    for (const auto& [key, stems] : groups) {
        const TubeTopology& topology = tubeTopology(std::get<0>(key), std::get<1>(key), std::get<2>(key));
        vertices += stems.size() * topology.vertices();
        indices += stems.size() * topology.indices.size();
        most = std::max(most, std::min(stems.size(), size_t(kLanes)) * topology.vertices());
    }

    Mesh mesh;
    mesh.positions.reserve(vertices);
    mesh.normals.reserve(vertices);
    mesh.indices.resize(indices);
    std::vector<float> controls;
    std::vector<glm::vec3> positions(most), normals(most);  // of kLanes tubes, on their way into memory that is not written twice
    size_t vertex = 0;
    uint32_t* index = mesh.indices.data();
    for (const auto& [key, stems] : groups) {
        const TubeTopology& topology = tubeTopology(std::get<0>(key), std::get<1>(key), std::get<2>(key));
        controls.assign(size_t(topology.controls()) * 3 * kLanes, 0.0f);
        const Polygon round = ringPolygon(topology.sides, 0, 0), lobed = ringPolygon(topology.sides, species.lobes, species.lobeDepth);
        for (size_t begin = 0; begin < stems.size(); begin += kLanes) {
            const size_t lanes = std::min(size_t(kLanes), stems.size() - begin);
            for (size_t lane = 0; lane < lanes; ++lane) {
                const Stem& stem = skeleton.stems[stems[begin + lane]];
                writeControls(stem, stem.level == 0 ? lobed : round, lane, controls.data());
            }
            evaluateTubes(topology, controls.data(), int(lanes), positions.data(), normals.data());
            const auto end = long(lanes * topology.vertices());
            mesh.positions.insert(mesh.positions.end(), positions.begin(), positions.begin() + end);
            mesh.normals.insert(mesh.normals.end(), normals.begin(), normals.begin() + end);
            for (size_t lane = 0; lane < lanes; ++lane, vertex += topology.vertices())
                for (const uint32_t i : topology.indices) *index++ = uint32_t(vertex) + i;
        }
    }
    return mesh;
}

}  // namespace dapple::scenegen
