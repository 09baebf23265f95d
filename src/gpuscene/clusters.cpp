#include "gpuscene/clusters.h"

#include "gpuscene/gpu_scene.h"

#include <algorithm>
#include <map>

namespace dapple::gpuscene {
namespace {

/// Triangles that stay together: one, or the two of a quad.
struct Unit {
    uint32_t mesh, firstIndex;
    auto operator<=>(const Unit&) const = default;
};

template <class Integer>
void append(std::vector<uint8_t>& bytes, std::span<const uint32_t> indices) {
    for (const uint32_t i : indices) {
        const auto value = Integer(i);
        const auto* first = reinterpret_cast<const uint8_t*>(&value);
        bytes.insert(bytes.end(), first, first + sizeof value);
    }
}

}  // namespace

std::vector<Part> clusters(const scenegen::Prototype& prototype, const GpuPrototype& gpu, uint32_t index, uint32_t triangles, size_t offset, std::vector<uint8_t>& bytes) {
    std::vector<const scenegen::Mesh*> meshes;  // parallel to those of `gpu`
    std::map<const scenegen::Mesh*, std::vector<uint32_t>> drawn;  // of those with slivers
    for (const scenegen::Mesh& mesh : prototype.meshes)
        if (!mesh.indices.empty()) {
            if (gpu.meshes[meshes.size()].packing.slivers) drawn[&mesh] = drawnIndices(mesh);
            meshes.push_back(&mesh);
        }
    const auto unitIndices = [&](uint32_t mesh) { return gpu.meshes[mesh].packing.indices == Packing::Indices::quads ? 6u : 3u; };
    const auto indicesOf = [&](const Unit& unit) {
        const auto own = drawn.find(meshes[unit.mesh]);
        return std::span(own != drawn.end() ? own->second : meshes[unit.mesh]->indices).subspan(unit.firstIndex, unitIndices(unit.mesh));
    };
    std::vector<Unit> units;
    std::vector<base::Box> boxes;
    std::vector<uint32_t> weights;
    for (uint32_t m = 0; m < meshes.size(); ++m)
        for (uint32_t first = 0; first < meshes[m]->indices.size(); first += unitIndices(m)) {
            units.push_back({m, first});
            boxes.emplace_back();
            for (const uint32_t v : indicesOf(units.back())) boxes.back().extend(meshes[m]->positions[v]);
            weights.push_back(unitIndices(m) / 3);
        }
    const Hierarchy hierarchy(boxes, weights, {.leafTriangles = triangles, .visitTriangles = 0});
    std::vector<Part> parts;
    for (uint32_t n = 0; n < hierarchy.nodes().size(); ++n) {
        const Hierarchy::Node& node = hierarchy.nodes()[n];
        if (!node.leaf()) continue;
        Part part{index, node.box, gpu.castsShadow, node.triangles, {}};
        std::vector<Unit> own;
        for (const uint32_t unit : hierarchy.items(n)) own.push_back(units[unit]);
        std::sort(own.begin(), own.end());  // neighbours share vertices
        for (auto unit = own.begin(); unit != own.end();) {
            const uint32_t from = unit->mesh;
            GpuMesh& piece = part.meshes.emplace_back(gpu.meshes[from]);
            const bool wide = piece.packing.indices == Packing::Indices::bits32;
            piece.packing.indices = wide ? Packing::Indices::bits32 : Packing::Indices::bits16;
            bytes.resize((bytes.size() + 3) / 4 * 4);
            piece.indexOffset = offset + bytes.size();
            piece.indexCount = 0;
            for (; unit != own.end() && unit->mesh == from; ++unit) {
                piece.indexCount += unitIndices(from);
                if (wide) append<uint32_t>(bytes, indicesOf(*unit));
                else append<uint16_t>(bytes, indicesOf(*unit));
            }
        }
        parts.push_back(std::move(part));
    }
    return parts;
}

}  // namespace dapple::gpuscene
