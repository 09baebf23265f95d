#pragma once

#include "scenegen/import/gltf_textures.h"

#include <string>
#include <vector>

namespace dapple::scenegen {

/// What a primitive needs to know of its material.
struct GltfSurface {
    uint32_t material = 0;      ///< index into GltfMaterials::materials
    uint32_t flat = 0;          ///< the same without texture, for primitives without texture coordinates
    bool visible = true;        ///< false: opacity and cut-off leave nothing of it
    bool flatVisible = true;
    size_t uvSet = 0;           ///< n of TEXCOORD_n
    glm::dmat3 uvTransform{1};  ///< KHR_texture_transform
};

/// The document's materials, equal ones merged, with the textures of their colours.
class GltfMaterials {
public:
    GltfMaterials(GltfDocument& document, GltfTextures& textures);

    /// Of a primitive's "material"; the specification's default where it names none.
    const GltfSurface& surfaceOf(const Json& primitive) const;

    std::vector<Material> materials;

private:
    GltfSurface read(const Json& json);
    uint32_t add(const Material& material);
    bool cutOut(Material& material, double opacity, const std::string& mode, double cutoff);

    GltfDocument& document_;
    GltfTextures& textures_;
    std::vector<GltfSurface> surfaces_;  ///< of each material of the file; the default at the end
};

/// The highlight that roughness and KHR_materials_specular ask for; none without the latter.
struct GltfHighlight {
    float specular = 0, shininess = 16;
};
GltfHighlight highlightOf(const Json& material);

}  // namespace dapple::scenegen
