#include "scenegen/import/gltf_materials.h"

#include "scenegen/gltf_highlight.h"
#include "scenegen/import/texture_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>

// Khronos, "glTF 2.0 Specification" (2021), section 3.9.
namespace dapple::scenegen {
namespace {

/// offset · rotation · scale. Angles are counter-clockwise as seen in the picture, whose v grows downwards.
glm::dmat3 transformOf(const Json& info) {
    const Json& json = extension(info, "KHR_texture_transform");
    if (json.is_null()) return glm::dmat3(1);
    const auto offset = vectorOf(member(json, "offset"), glm::dvec2(0)), scale = vectorOf(member(json, "scale"), glm::dvec2(1));
    const double angle = valueOf(json, "rotation", 0.0), c = std::cos(angle), s = std::sin(angle);
    return {{c * scale.x, -s * scale.x, 0}, {s * scale.y, c * scale.y, 0}, {offset.x, offset.y, 1}};
}

/// Where KHR_materials_pbrSpecularGlossiness stands, colour and texture are its own.
struct Colour {
    glm::dvec4 factor{1};
    const Json* texture = nullptr;
};
Colour colourOf(const Json& material) {
    const Json& glossy = extension(material, "KHR_materials_pbrSpecularGlossiness");
    if (!glossy.is_null()) return {vectorOf(member(glossy, "diffuseFactor"), glm::dvec4(1)), &member(glossy, "diffuseTexture")};
    const Json& surface = member(material, "pbrMetallicRoughness");
    return {vectorOf(member(surface, "baseColorFactor"), glm::dvec4(1)), &member(surface, "baseColorTexture")};
}

}  // namespace

GltfHighlight highlightOf(const Json& material) {
    GltfHighlight result;
    result.shininess = shininessOf(valueOf(member(material, "pbrMetallicRoughness"), "roughnessFactor", 1.0));
    const Json& specular = extension(material, "KHR_materials_specular");
    if (specular.is_null() || result.shininess < 1) return result;  // below: no highlight that a pixel could show
    const auto colour = vectorOf(member(specular, "specularColorFactor"), glm::dvec3(1));
    const double strength = valueOf(specular, "specularFactor", 1.0) * std::max({colour.x, colour.y, colour.z});
    result.specular = float(std::clamp(strength * highlightScale(result.shininess), 0.0, 1.0));
    return result;
}

GltfMaterials::GltfMaterials(GltfDocument& document, GltfTextures& textures, SceneBuilder& builder)
    : document_(document), textures_(textures), builder_(builder) {
    for (size_t i = 0; i < document.count("materials"); ++i) surfaces_.push_back(read(document.item("materials", i)));
    surfaces_.push_back(read(Json::object()));
}

const GltfSurface& GltfMaterials::surfaceOf(const Json& primitive) const {
    const size_t i = document_.indexOr(primitive, "material", surfaces_.size() - 1);
    if (i >= surfaces_.size()) document_.fail(fmt::format("is damaged: asks for materials[{}], which does not exist", i));
    return surfaces_[i];
}

GltfSurface GltfMaterials::read(const Json& json) {
    const Colour colour = colourOf(json);
    Material m;
    m.name = valueOf<std::string>(json, "name", "");
    m.albedo = glm::vec3(glm::clamp(glm::dvec3(colour.factor), 0.0, 1.0));
    m.specular = highlightOf(json).specular;
    m.shininess = highlightOf(json).shininess;
    const std::string mode = valueOf<std::string>(json, "alphaMode", "OPAQUE");
    if (mode == "BLEND") document_.notes.add("alphaMode BLEND is drawn as a cut-out at an opacity of 1/2", m.name);
    const double cutoff = mode == "MASK" ? valueOf(json, "alphaCutoff", 0.5) : 0.5, opacity = std::clamp(colour.factor.a, 0.0, 1.0);
    const auto add = [&](int texture) {
        m.texture = texture;
        // What is opaque ignores alpha, and no alpha is below 0.
        const bool drawn = mode == "OPAQUE" || cutoff <= 0 || setOpacity(m, textures_.textures, texture, float(opacity), float(cutoff));
        return drawn ? int(builder_.addMaterial(m)) : -1;
    };
    GltfSurface surface;
    surface.material = surface.flat = add(-1);
    if (colour.texture->is_null()) return surface;
    surface.material = add(textures_.load(document_.index(*colour.texture, "index")));
    surface.uvTransform = transformOf(*colour.texture);
    const size_t set = document_.indexOr(*colour.texture, "texCoord", 0);
    const Json& transform = extension(*colour.texture, "KHR_texture_transform");
    surface.uvSet = transform.is_null() ? set : document_.indexOr(transform, "texCoord", set);
    return surface;
}

}  // namespace dapple::scenegen
