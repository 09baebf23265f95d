#pragma once

#include "scenegen/import/budget.h"
#include "scenegen/import/scene_builder.h"

#include <string>
#include <vector>

namespace dapple::scenegen {

/// What the faces of a file name, in its own axes and units, in double precision.
struct PolygonData {
    std::vector<glm::dvec3> positions, normals;
    std::vector<glm::dvec2> uvs;  ///< v grows upwards
};

/// Faces of one material.
struct Faces {
    /// Indices into PolygonData; kNone where the file gives none.
    struct Corner {
        static constexpr int64_t kNone = -1;
        int64_t position = kNone, uv = kNone, normal = kNone;
    };
    std::vector<Corner> corners;
    std::vector<uint32_t> sizes;  ///< corners per face, 3 or more
};

/// What a material of the file becomes.
struct Look {
    /// Index into FileScene::materials, with and without texture coordinates; -1: not drawn.
    int textured = -1, flat = -1;
    glm::dvec2 scale{1}, offset{0};  ///< of the texture: u' = scale · u + offset, v growing upwards
};

struct ObjectPart {
    const Faces* faces;
    Look look;
};

/// Adds an object. Far from the origin its whole metres become those of its node, before anything is a float. Polygons
/// are cut into triangles; without normals, normals are made. Throws UsageError when a face names a vertex that the
/// file does not have, or that is not finite.
void addPolygonObject(SceneBuilder& builder, const Budget& budget, const PolygonData& data, const std::string& name,
                      const std::vector<ObjectPart>& parts);

}  // namespace dapple::scenegen
