#include "scenegen/plants/tube.h"

#include "base/detmath.h"
#include "scenegen/plants/lanes.h"
#include "scenegen/plants/vertex_order.h"

#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <memory>
#include <mutex>
#include <tuple>

namespace dapple::scenegen {
namespace {
namespace Far = OpenSubdiv::Far;

static_assert(kLanes == 16);

/// A row of the refinement matrix: the weight of every control point.
struct Row {
    std::vector<double> w;
    void Clear(void* = nullptr) { std::fill(w.begin(), w.end(), 0.0); }
    void AddWithWeight(const Row& other, double weight) {
        for (size_t i = 0; i < w.size(); ++i) w[i] += weight * other.w[i];
    }
};

std::vector<int> cageQuads(int sides, int rings) {
    std::vector<int> quads;
    const auto quad = [&](int a, int b, int c, int d) { quads.insert(quads.end(), {a, b, c, d}); };
    for (int r = 0; r + 1 < rings; ++r)
        for (int k = 0; k < sides; ++k) {
            const int next = (k + 1) % sides;
            quad(r * sides + k, r * sides + next, (r + 1) * sides + next, (r + 1) * sides + k);
        }
    const int top = (rings - 1) * sides;
    for (int k = 0; k < sides / 2 - 1; ++k) {
        quad(sides - 1 - k, sides - 2 - k, k + 1, k);
        quad(top + k, top + k + 1, top + sides - 2 - k, top + sides - 1 - k);
    }
    return quads;
}

std::unique_ptr<const TubeTopology> build(int sides, int rings, int refine) {
    std::vector<int> quads = cageQuads(sides, rings);
    const std::vector<int> sizes(quads.size() / 4, 4);
    Far::TopologyDescriptor descriptor;
    descriptor.numVertices = sides * rings;
    descriptor.numFaces = int(sizes.size());
    descriptor.numVertsPerFace = sizes.data();
    descriptor.vertIndicesPerFace = quads.data();
    using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
    std::unique_ptr<Far::TopologyRefiner> refiner(
        Factory::Create(descriptor, Factory::Options(OpenSubdiv::Sdc::SCHEME_CATMARK, OpenSubdiv::Sdc::Options())));
    if (refine > 0) {
        Far::TopologyRefiner::UniformOptions options(refine);
        options.fullTopologyInLastLevel = true;  // without it Limit() returns nothing
        refiner->RefineUniform(options);
    }

    const size_t controls = size_t(sides * rings);
    const auto zeros = [&](int n) { return std::vector<Row>(size_t(n), Row{std::vector<double>(controls, 0.0)}); };
    std::vector<Row> basis = zeros(int(controls));
    for (size_t i = 0; i < controls; ++i) basis[i].w[i] = 1;
    const Far::PrimvarRefinerReal<double> primvar(*refiner);
    for (int level = 1; level <= refine; ++level) {
        std::vector<Row> next = zeros(refiner->GetLevel(level).GetNumVertices());
        primvar.Interpolate(level, basis, next);
        basis = std::move(next);
    }
    const Far::TopologyLevel& last = refiner->GetLevel(refine);
    std::vector<Row> p = zeros(last.GetNumVertices()), du = p, dv = p;
    primvar.Limit(basis, p, du, dv);

    auto topology = std::make_unique<TubeTopology>();
    topology->sides = sides, topology->rings = rings, topology->refine = refine;
    for (int f = 0; f < last.GetNumFaces(); ++f) {
        const auto v = last.GetFaceVertices(f);
        for (const int corner : {0, 1, 2, 0, 2, 3}) topology->indices.push_back(uint32_t(v[corner]));
    }
    const std::vector<uint32_t> order = orderForVertexCache(topology->indices, size_t(last.GetNumVertices()));
    for (const uint32_t v : order) {
        topology->first.push_back(uint32_t(topology->weights.size()));
        for (uint32_t c = 0; c < controls; ++c) {
            const TubeTopology::Weight w{c, float(p[v].w[c]), float(du[v].w[c]), float(dv[v].w[c])};
            // Sums that cancel leave 1e-17, not 0.
            if (std::abs(w.position) + std::abs(w.tangentU) + std::abs(w.tangentV) > 1e-9f) topology->weights.push_back(w);
        }
    }
    topology->first.push_back(uint32_t(topology->weights.size()));
    return topology;
}

/// For lanes of the first `quads` groups of four: a tree has one trunk, not sixteen. Groups are written out as Float4
/// because g++ at -O2 keeps sums in arrays of float in memory, which halves the speed.
template <size_t quads>
void evaluate(const TubeTopology& topology, const float* controls, int lanes, glm::vec3* positions, glm::vec3* normals) {
    constexpr size_t kCount = 4 * quads;
    const uint32_t count = topology.vertices();
    for (uint32_t v = 0; v < count; ++v) {
        std::array<float, 3 * kCount> p, u, w;
        // One axis at a time: three sums of 16 lanes are twelve registers, with three weights and a load all sixteen.
        for (size_t axis = 0; axis < 3; ++axis) {
            Float4 sp[quads] = {}, su[quads] = {}, sw[quads] = {};
            for (uint32_t i = topology.first[v]; i < topology.first[v + 1]; ++i) {
                const TubeTopology::Weight& weight = topology.weights[i];
                const float* c = controls + (size_t(weight.control) * 3 + axis) * kLanes;
#pragma GCC unroll 4
                for (size_t q = 0; q < quads; ++q) {
                    Float4 lane;
                    std::memcpy(&lane, c + 4 * q, sizeof(lane));
                    sp[q] += weight.position * lane;
                    su[q] += weight.tangentU * lane;
                    sw[q] += weight.tangentV * lane;
                }
            }
            std::memcpy(&p[axis * kCount], sp, sizeof(sp));
            std::memcpy(&u[axis * kCount], su, sizeof(su));
            std::memcpy(&w[axis * kCount], sw, sizeof(sw));
        }
        std::array<float, 3 * kCount> n;
        for (size_t k = 0; k < kCount; ++k) {
            const size_t x = k, y = k + kCount, z = k + 2 * kCount;
            const float nx = u[y] * w[z] - u[z] * w[y], ny = u[z] * w[x] - u[x] * w[z], nz = u[x] * w[y] - u[y] * w[x];
            const float scale = 1 / std::sqrt(nx * nx + ny * ny + nz * nz);
            n[x] = nx * scale, n[y] = ny * scale, n[z] = nz * scale;
        }
        for (int k = 0; k < lanes; ++k) {
            const size_t at = size_t(k) * count + v, lane = size_t(k);
            positions[at] = {p[lane], p[lane + kCount], p[lane + 2 * kCount]};
            normals[at] = {n[lane], n[lane + kCount], n[lane + 2 * kCount]};
        }
    }
}

}  // namespace

const TubeTopology& tubeTopology(int sides, int rings, int refine) {
    static std::mutex mutex;
    static std::map<std::tuple<int, int, int>, std::unique_ptr<const TubeTopology>> cache;
    const std::lock_guard lock(mutex);
    std::unique_ptr<const TubeTopology>& entry = cache[{sides, rings, refine}];
    if (!entry) entry = build(sides, rings, refine);
    return *entry;
}

size_t tubeTriangles(int sides, int rings, int refine) {
    return size_t(sides * (rings - 1) + sides - 2) * (size_t{2} << (2 * refine));
}

double cageScale(int sides) { return 3 / (2 + base::det::cos(2 * base::det::kPi / sides)); }

void evaluateTubes(const TubeTopology& topology, const float* controls, int lanes, glm::vec3* positions, glm::vec3* normals) {
    switch ((lanes + 3) / 4) {
        case 1: return evaluate<1>(topology, controls, lanes, positions, normals);
        case 2: return evaluate<2>(topology, controls, lanes, positions, normals);
        case 3: return evaluate<3>(topology, controls, lanes, positions, normals);
        default: return evaluate<4>(topology, controls, lanes, positions, normals);
    }
}

}  // namespace dapple::scenegen
