#include "gpuscene/pack.h"

#include "scenegen/lod/grid.h"

#include <glm/gtc/packing.hpp>

#include <algorithm>
#include <bit>
#include <cmath>

namespace dapple::gpuscene {
namespace {

/// Exponent of the lowest bit of a finite float that is not 0.
int lowestBit(float v) {
    const uint32_t bits = std::bit_cast<uint32_t>(v), mantissa = bits & 0x7FFFFF;
    const int exponent = int(bits >> 23 & 0xFF);
    if (exponent == 0) return -149 + std::countr_zero(mantissa);
    return exponent - 150 + (mantissa ? std::countr_zero(mantissa) : 23);
}

bool isHalf(const glm::vec2& uv) { return glm::unpackHalf2x16(glm::packHalf2x16(uv)) == uv; }

/// Whether every triangle is shaded by the normal of its plane, to within a degree. Triangles without area say nothing.
bool isFlat(const scenegen::Mesh& mesh) {
    for (size_t i = 0; i < mesh.indices.size(); i += 3) {
        const uint32_t a = mesh.indices[i], b = mesh.indices[i + 1], c = mesh.indices[i + 2];
        const glm::dvec3 plane = glm::cross(glm::dvec3(mesh.positions[b]) - glm::dvec3(mesh.positions[a]), glm::dvec3(mesh.positions[c]) - glm::dvec3(mesh.positions[a]));
        const double area = glm::length(plane);
        for (const uint32_t v : {a, b, c})
            if (area > 0 && std::abs(glm::dot(glm::dvec3(mesh.normals[v]), plane)) < 0.99985 * area) return false;
    }
    return true;
}

/// True if the triangle whose indices begin at `first` is higher than the rounding of its corners' coordinates.
bool hasArea(const scenegen::Mesh& mesh, size_t first) {
    const auto corner = [&](size_t k) { return glm::dvec3(mesh.positions[mesh.indices[first + k]]); };
    const glm::dvec3 a = corner(0), p = corner(1) - a, q = corner(2) - a, far = glm::abs(a) + glm::max(glm::abs(p), glm::abs(q));
    const double twiceArea = glm::length(glm::cross(p, q)), side = std::sqrt(std::max({glm::dot(p, p), glm::dot(q, q), glm::dot(q - p, q - p)}));
    return twiceArea > 0x1p-22 * std::max({far.x, far.y, far.z}) * side;
}

bool hasSlivers(const scenegen::Mesh& mesh) {
    for (size_t i = 0; i < mesh.indices.size(); i += 3)
        if (!hasArea(mesh, i)) return true;
    return false;
}

void steps(const Packing& packing, const glm::vec3& at, uint16_t (&position)[3]) {
    for (int k = 0; k < 3; ++k) position[k] = uint16_t((double(at[k]) - double(packing.grid[k])) / double(packing.grid.w));
}

template <class Integer>
void pack(const glm::vec3& unitNormal, Integer (&normal)[2]) {
    constexpr float top = float((1 << (8 * sizeof(Integer) - 1)) - 1);
    const glm::vec2 oct = octahedral(unitNormal);
    for (int k = 0; k < 2; ++k) normal[k] = Integer(std::lround(oct[k] * top));
}

}  // namespace

Packing choosePacking(const scenegen::Mesh& mesh) {
    Packing packing;
    base::Box box;
    int lowest = 127;
    for (const glm::vec3& p : mesh.positions) {
        box.extend(p);
        for (int k = 0; k < 3; ++k)
            if (p[k] != 0) lowest = std::min(lowest, lowestBit(p[k]));
    }
    const float step = std::exp2(float(lowest));
    // Far from the range in which the steps, or their products, would not be normal floats.
    if (!box.empty() && std::abs(lowest) < 60) {
        const glm::dvec3 steps = (glm::dvec3(box.hi) - glm::dvec3(box.lo)) / double(step);
        if (std::max({steps.x, steps.y, steps.z}) <= 65535 && std::all_of(mesh.uvs.begin(), mesh.uvs.end(), isHalf)) {
            packing.vertices = isFlat(mesh) ? Packing::Vertices::flat : Packing::Vertices::compact;
            packing.grid = {box.lo, step};
        }
    }
    packing.slivers = hasSlivers(mesh);
    if (mesh.positions.size() <= 65536) packing.indices = !packing.slivers && scenegen::isQuadList(mesh) ? Packing::Indices::quads : Packing::Indices::bits16;
    return packing;
}

std::vector<uint32_t> drawnIndices(const scenegen::Mesh& mesh) {
    std::vector<uint32_t> indices = mesh.indices;
    for (size_t i = 0; i < indices.size(); i += 3)
        if (!hasArea(mesh, i)) indices[i + 1] = indices[i + 2] = indices[i];
    return indices;
}

size_t Packing::bytes(const scenegen::Mesh& mesh) const {
    constexpr size_t kVertex[] = {sizeof(FloatVertex), sizeof(CompactVertex), sizeof(FlatVertex)};
    const size_t vertex = kVertex[size_t(vertices)], uv = vertices == Vertices::floats ? 8 : 4;
    const size_t index = indices == Indices::quads ? 0 : indices == Indices::bits16 ? 2 : 4;
    return mesh.positions.size() * vertex + mesh.uvs.size() * uv + mesh.indices.size() * index;
}

glm::vec2 octahedral(const glm::vec3& n) {
    const float sum = std::abs(n.x) + std::abs(n.y) + std::abs(n.z);
    if (sum == 0) return {0, 0};  // no normal; up is as good as any
    const glm::vec2 flat = glm::vec2(n) / sum;
    if (n.z >= 0) return flat;
    return {(1 - std::abs(flat.y)) * (flat.x >= 0 ? 1.0f : -1.0f), (1 - std::abs(flat.x)) * (flat.y >= 0 ? 1.0f : -1.0f)};
}

CompactVertex::CompactVertex(const Packing& packing, const glm::vec3& at, const glm::vec3& unitNormal) {
    steps(packing, at, position);
    pack(unitNormal, normal);
}

FlatVertex::FlatVertex(const Packing& packing, const glm::vec3& at) { steps(packing, at, position); }

FloatVertex::FloatVertex(const glm::vec3& at, const glm::vec3& unitNormal) : position(at) { pack(unitNormal, normal); }

size_t packedBytes(const scenegen::Scene& scene) {
    size_t sum = 0;
    for (const scenegen::Prototype& prototype : scene.prototypes)
        for (const scenegen::Mesh& mesh : prototype.meshes)
            if (!mesh.indices.empty()) sum += choosePacking(mesh).bytes(mesh);
    return sum;
}

}  // namespace dapple::gpuscene
