#pragma once

#include "scenegen/import/gltf_textures.h"
#include "scenegen/import/scene_builder.h"

#include <string>
#include <vector>

namespace dapple::scenegen {

/// What a primitive needs to know of its material.
struct GltfSurface {
    int material = 0;           ///< index into FileScene::materials; -1: opacity and cut-off leave nothing of it
    int flat = 0;               ///< the same without texture, for primitives without texture coordinates
    size_t uvSet = 0;           ///< n of TEXCOORD_n
    glm::dmat3 uvTransform{1};  ///< KHR_texture_transform
};

/// The document's materials in the builder's scene, with the textures of their colours.
class GltfMaterials {
public:
    GltfMaterials(GltfDocument& document, GltfTextures& textures, SceneBuilder& builder);

    /// The material of a primitive; the specification's default where the primitive names none.
    const GltfSurface& surfaceOf(const Json& primitive) const;

private:
    GltfSurface read(const Json& json);

    GltfDocument& document_;
    GltfTextures& textures_;
    SceneBuilder& builder_;
    std::vector<GltfSurface> surfaces_;  ///< of each material of the file; the default at the end
};

/// The highlight that roughness and KHR_materials_specular ask for; none without the latter.
struct GltfHighlight {
    float specular = 0, shininess = 16;
};
GltfHighlight highlightOf(const Json& material);

}  // namespace dapple::scenegen
