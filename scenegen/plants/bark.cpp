#include "scenegen/plants/bark.h"

#include "base/detmath.h"
#include "scenegen/plants/tube.h"

#include <algorithm>
#include <array>
#include <map>
#include <tuple>

namespace dapple::scenegen {
namespace {

constexpr int kCoarsest = 3;

/// Share of a scarce budget that stems other than twigs may use.
constexpr double kWoodShare = 0.92;

struct Cage {
    int sides, rings, refine;
    size_t triangles() const { return tubeTriangles(sides, rings, refine); }
};

Cage cageOf(const Species& species, const Stem& stem, int coarser) {
    const LevelParameters& p = species.levels[size_t(stem.level)];
    return {coarser >= 2 ? std::max(4, p.sides / 4 * 2) : p.sides, int(stem.rings.size()), std::max(0, p.refine - coarser)};
}

/// Keeps share/of of the stems for which `candidate` holds, evenly, and of the others those whose parent is kept.
template <class Candidate>
std::vector<bool> thin(const Skeleton& skeleton, const std::vector<bool>& kept, size_t share, size_t of, Candidate candidate) {
    std::vector<bool> result = kept;
    size_t seen = 0;
    for (size_t i = 0; i < kept.size(); ++i) {
        const Stem& stem = skeleton.stems[i];
        if (stem.parent >= 0 && !result[size_t(stem.parent)]) result[i] = false;
        if (!result[i] || !candidate(stem)) continue;
        result[i] = (seen + 1) * share / of != seen * share / of;
        ++seen;
    }
    return result;
}

/// Writes lane `lane` of the control points, [control][xyz][lane].
void writeControls(const Species& species, const Stem& stem, const Cage& cage, size_t lane, float* controls) {
    std::array<base::det::SinCos, 32> circle;
    std::array<double, 32> lobes;
    const bool lobed = stem.level == 0 && species.lobeDepth > 0;
    for (int k = 0; k < cage.sides; ++k) {
        const double angle = 2 * base::det::kPi * k / cage.sides;
        circle[size_t(k)] = base::det::sinCos(angle);
        lobes[size_t(k)] = lobed ? 1 + species.lobeDepth * base::det::sin(species.lobes * angle) : 1;
    }
    const double scale = cageScale(cage.sides);
    float* out = controls + lane;
    for (size_t i = 0; i < stem.rings.size(); ++i) {
        const Ring& ring = stem.rings[i];
        const glm::dvec3 centre = stem.cageCentre(i);
        for (int k = 0; k < cage.sides; ++k, out += 3 * kLanes) {
            const double r = ring.radius * scale * lobes[size_t(k)];
            const glm::dvec3 p = centre + ring.frame[0] * (r * circle[size_t(k)].cos) + ring.frame[1] * (r * circle[size_t(k)].sin);
            for (int axis = 0; axis < 3; ++axis) out[axis * kLanes] = float(p[axis]);
        }
    }
}

}  // namespace

BarkPlan planBark(const Species& species, Skeleton& skeleton, size_t budget) {
    const int twigLevel = int(species.levels.size()) - 1;
    const auto isTwig = [&](const Stem& s) { return s.level == twigLevel; };
    const auto isLimb = [&](const Stem& s) { return s.level > 0 && s.level < twigLevel; };
    int coarser = 0;
    std::vector<bool> kept(skeleton.stems.size(), true);
    size_t trunks = 0, limbs = 0, twigs = 0;
    const auto count = [&] {
        trunks = limbs = twigs = 0;
        for (size_t i = 0; i < kept.size(); ++i)
            if (kept[i])
                (isTwig(skeleton.stems[i]) ? twigs : isLimb(skeleton.stems[i]) ? limbs : trunks) += cageOf(species, skeleton.stems[i], coarser).triangles();
    };
    count();
    if (budget > 0) {
        while (coarser < kCoarsest && trunks + limbs + twigs / 2 > budget) {
            if (++coarser == kCoarsest) thinRings(skeleton);
            count();
        }
        const auto wood = size_t(kWoodShare * double(budget));
        if (trunks + limbs + twigs / 2 > budget && trunks + limbs > wood) {
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
    for (const uint32_t i : plan.kept) {
        const Cage cage = cageOf(species, skeleton.stems[i], plan.coarser);
        groups[{cage.sides, cage.rings, cage.refine}].push_back(i);
    }
    size_t vertices = 0, indices = 0;
    for (const auto& [key, stems] : groups) {
        const TubeTopology& topology = tubeTopology(std::get<0>(key), std::get<1>(key), std::get<2>(key));
        vertices += stems.size() * topology.vertices();
        indices += stems.size() * topology.indices.size();
    }

    Mesh mesh;
    mesh.positions.resize(vertices);
    mesh.normals.resize(vertices);
    mesh.indices.resize(indices);
    std::vector<float> controls;
    size_t vertex = 0;
    uint32_t* index = mesh.indices.data();
    for (const auto& [key, stems] : groups) {
        const TubeTopology& topology = tubeTopology(std::get<0>(key), std::get<1>(key), std::get<2>(key));
        controls.assign(size_t(topology.controls()) * 3 * kLanes, 0.0f);
        for (size_t begin = 0; begin < stems.size(); begin += kLanes) {
            const size_t lanes = std::min(size_t(kLanes), stems.size() - begin);
            for (size_t lane = 0; lane < lanes; ++lane) {
                const Stem& stem = skeleton.stems[stems[begin + lane]];
                writeControls(species, stem, cageOf(species, stem, plan.coarser), lane, controls.data());
            }
            evaluateTubes(topology, controls.data(), int(lanes), &mesh.positions[vertex], &mesh.normals[vertex]);
            for (size_t lane = 0; lane < lanes; ++lane, vertex += topology.vertices())
                for (const uint32_t i : topology.indices) *index++ = uint32_t(vertex) + i;
        }
    }
    return mesh;
}

}  // namespace dapple::scenegen
