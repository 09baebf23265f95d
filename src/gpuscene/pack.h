#pragma once

#include "scenegen/scene.h"

namespace dapple::gpuscene {

/// How a mesh lies in GPU memory, and what that takes. Nothing is rounded but normals.
struct Packing {
    enum class Vertices {
        floats,   ///< FloatVertex; two floats of texture coordinates
        compact,  ///< positions lie on a grid of 65,536 steps a side (scenegen/lod/grid.h), texture coordinates are halves
        flat,     ///< compact, and each triangle's normal is that of its plane, which a fragment knows: none is stored
    } vertices = Vertices::floats;
    /// position = grid.xyz + grid.w · (what is stored), without rounding; (0, 0, 0, 1) where floats are stored.
    glm::vec4 grid{0, 0, 0, 1};
    enum class Indices {
        quads,  ///< scenegen::isQuadList: all such meshes share one list
        bits16,
        bits32,
    } indices = Indices::bits32;
    bool slivers = false;  ///< the mesh has triangles without area: see drawnIndices()

    /// Of the mesh alone; the list of the quads is shared.
    size_t bytes(const scenegen::Mesh& mesh) const;
};

Packing choosePacking(const scenegen::Mesh& mesh);

/// As many indices as the mesh has. A triangle without area gets one corner three times: no ray can hit it, but
/// where its corners are rounded apart a rasteriser would draw it.
std::vector<uint32_t> drawnIndices(const scenegen::Mesh& mesh);

/// Quads of the shared list: as many as 16-bit indices reach.
inline constexpr size_t kSharedQuads = 65536 / 4;

/// Octahedral encoding of a unit vector (Cigolle et al. 2014, "Survey of Efficient Representations for Independent Unit
/// Vectors"), both components in [-1, 1]; unpackOctahedral() of lib/instance.glsl undoes it.
glm::vec2 octahedral(const glm::vec3& unit);

struct CompactVertex {
    CompactVertex(const Packing& packing, const glm::vec3& position, const glm::vec3& unitNormal);
    uint16_t position[3];
    int8_t normal[2];  ///< octahedral, to within a degree
};
static_assert(sizeof(CompactVertex) == 8);

struct FloatVertex {
    FloatVertex(const glm::vec3& at, const glm::vec3& unitNormal);
    glm::vec3 position;
    int16_t normal[2];
};
static_assert(sizeof(FloatVertex) == 16);

struct FlatVertex {
    FlatVertex(const Packing& packing, const glm::vec3& position);
    uint16_t position[3];
};
static_assert(sizeof(FlatVertex) == 6);

/// Bytes of all prototypes of a scene, packed.
size_t packedBytes(const scenegen::Scene& scene);

}  // namespace dapple::gpuscene
