#include "scenegen/import/gltf_materials.h"

#include "scenegen/gltf_highlight.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>

// Khronos, "glTF 2.0 Specification" (2021), section 3.9.
namespace dapple::scenegen {
namespace {

bool anyBelow(const base::Image8& image, double cutoff) {
    for (size_t i = 3; i < image.texels.size(); i += 4)
        if (float(image.texels[i]) / 255.0f < float(cutoff)) return true;
    return false;
}

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

GltfMaterials::GltfMaterials(GltfDocument& document, GltfTextures& textures) : document_(document), textures_(textures) {
    for (size_t i = 0; i < document.count("materials"); ++i) surfaces_.push_back(read(document.item("materials", i)));
    surfaces_.push_back(read(Json::object()));
}

const GltfSurface& GltfMaterials::surfaceOf(const Json& primitive) const {
    const size_t i = document_.indexOr(primitive, "material", surfaces_.size() - 1);
    if (i >= surfaces_.size()) document_.fail(fmt::format("is damaged: asks for materials[{}], which does not exist", i));
    return surfaces_[i];
}

/// Makes the material's cut-out of opacity factor, texture and cut-off; false: nothing of it is left.
bool GltfMaterials::cutOut(Material& material, double opacity, const std::string& mode, double cutoff) {
    if (mode == "OPAQUE") return true;  // alpha is ignored
    if (material.texture < 0) return opacity >= cutoff;
    const double ofTexture = opacity > 0 ? cutoff / opacity : 2;
    material.alphaTested = anyBelow(textures_.textures[size_t(material.texture)].image, ofTexture);
    material.alphaCutoff = material.alphaTested ? float(std::min(ofTexture, 1.0)) : kAlphaCutoff;
    return ofTexture <= 1 || cutoff <= 0;
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
    GltfSurface surface;
    Material flat = m;
    surface.flatVisible = cutOut(flat, opacity, mode, cutoff);
    surface.flat = surface.material = add(flat);
    surface.visible = surface.flatVisible;
    if (colour.texture->is_null()) return surface;
    m.texture = textures_.load(document_.index(*colour.texture, "index"));
    surface.visible = cutOut(m, opacity, mode, cutoff);
    surface.material = add(m);
    surface.uvTransform = transformOf(*colour.texture);
    const size_t set = document_.indexOr(*colour.texture, "texCoord", 0);
    const Json& transform = extension(*colour.texture, "KHR_texture_transform");
    surface.uvSet = transform.is_null() ? set : document_.indexOr(transform, "texCoord", set);
    return surface;
}

uint32_t GltfMaterials::add(const Material& m) {
    const auto key = [](const Material& x) {
        return std::tuple(x.albedo.x, x.albedo.y, x.albedo.z, x.specular, x.shininess, x.texture, x.alphaTested, x.alphaCutoff);
    };
    const auto it = std::ranges::find_if(materials, [&](const Material& x) { return key(x) == key(m); });
    if (it != materials.end()) return uint32_t(it - materials.begin());
    materials.push_back(m);
    return uint32_t(materials.size() - 1);
}

}  // namespace dapple::scenegen
