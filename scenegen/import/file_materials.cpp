#include "scenegen/import/scene_builder.h"
#include "scenegen/import/texture_files.h"

#include <assimp/material.h>
#include <assimp/scene.h>

#include <algorithm>
#include <array>

namespace dapple::scenegen {
namespace fs = std::filesystem;
namespace {

std::optional<base::Image8> decodeEmbedded(const aiTexture& texture, const std::string& name) {
    const auto* bytes = reinterpret_cast<const uint8_t*>(texture.pcData);
    if (texture.mHeight == 0) return base::decodeImage({bytes, texture.mWidth}, name);
    base::Image8 image{int(texture.mWidth), int(texture.mHeight), 4, {}};
    image.texels.reserve(size_t(texture.mWidth) * texture.mHeight * 4);
    for (size_t i = 0; i < size_t(texture.mWidth) * texture.mHeight; ++i) {
        const aiTexel& t = texture.pcData[i];
        image.texels.insert(image.texels.end(), {t.r, t.g, t.b, t.a});
    }
    return image;
}

Wrap wrapOf(aiTextureMapMode mode) {
    return mode == aiTextureMapMode_Mirror ? Wrap::mirror : mode == aiTextureMapMode_Wrap ? Wrap::repeat : Wrap::clamp;
}

std::string texturePath(const aiMaterial& material, aiTextureType type, unsigned* uvChannel = nullptr,
                        std::array<aiTextureMapMode, 3>* modes = nullptr) {
    aiString path;
    if (material.GetTexture(type, 0, &path, nullptr, uvChannel, nullptr, nullptr, modes ? modes->data() : nullptr) != aiReturn_SUCCESS) return {};
    return path.C_Str();
}

Material flatMaterial(const aiMaterial& source, const std::string& extension) {
    // Assimp does not deliver how strong Blender's highlight is, and at full strength brick gleams.
    const bool hasHighlight = extension != ".blend";
    Material m;
    m.name = source.GetName().C_Str();
    aiColor3D diffuse(0.5f, 0.5f, 0.5f), specular(0, 0, 0);
    float strength = 1, shininess = 0;
    source.Get(AI_MATKEY_COLOR_DIFFUSE, diffuse);
    source.Get(AI_MATKEY_COLOR_SPECULAR, specular);
    source.Get(AI_MATKEY_SHININESS_STRENGTH, strength);
    source.Get(AI_MATKEY_SHININESS, shininess);
    for (int i = 0; i < 3; ++i) m.albedo[i] = linearFromSrgb(std::clamp(diffuse[unsigned(i)], 0.0f, 1.0f));
    if (hasHighlight && shininess >= 1) {  // below: no highlight that a pixel could show
        m.specular = std::clamp(strength * std::max({specular.r, specular.g, specular.b}), 0.0f, 1.0f);
        m.shininess = std::min(shininess, 1024.0f);
    }
    return m;
}

}  // namespace

std::string lowerExtension(const fs::path& file) {
    std::string extension = file.extension().string();
    std::ranges::transform(extension, extension.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    return extension;
}

FileMaterials readFileMaterials(const aiScene& scene, const fs::path& file, const Sidecar& sidecar, SceneBuilder& builder) {
    const std::string extension = lowerExtension(file);
    TextureFiles textures(file, sidecar);
    textures.embedded = [&](const std::string& name) -> std::optional<base::Image8> {
        const aiTexture* texture = scene.GetEmbeddedTexture(name.c_str());
        return texture ? decodeEmbedded(*texture, name) : std::nullopt;
    };
    FileMaterials result;
    const auto addTo = [&](std::vector<int>& list, Material m, int texture, float opacity) {
        list.push_back(setOpacity(m, textures.textures, texture, opacity) ? int(builder.addMaterial(m)) : -1);
    };
    for (unsigned i = 0; i < scene.mNumMaterials; ++i) {
        const aiMaterial& source = *scene.mMaterials[i];
        Material m = flatMaterial(source, extension);
        float opacity = 1;
        source.Get(AI_MATKEY_OPACITY, opacity);
        noteOpacity(builder.scene.notes, opacity, m.name);
        addTo(result.flatOfAssimp, m, -1, opacity);

        unsigned uvChannel = 0;
        std::array<aiTextureMapMode, 3> modes{aiTextureMapMode_Wrap, aiTextureMapMode_Wrap, aiTextureMapMode_Wrap};
        std::string colour = texturePath(source, aiTextureType_BASE_COLOR, &uvChannel, &modes);
        if (colour.empty()) colour = texturePath(source, aiTextureType_DIFFUSE, &uvChannel, &modes);
        const bool hasColour = !colour.empty();
        const std::string mask = hasColour ? texturePath(source, aiTextureType_OPACITY)
                                           : texturePath(source, aiTextureType_OPACITY, &uvChannel, &modes);
        int texture = -1;
        if (hasColour || !mask.empty())
            texture = textures.load({colour, mask, 0, wrapOf(modes[0]), wrapOf(modes[1]), {}});
        // Blender's old materials replace their colour and opacity by the texture's, AC3D adds emission to it up to white; and
        // many exporters leave a textured material black.
        const bool replaces = extension == ".blend" || extension == ".ac" || extension == ".acc";
        if (texture >= 0 && (replaces || std::max({m.albedo.r, m.albedo.g, m.albedo.b}) < 0.01f)) m.albedo = glm::vec3(1);
        addTo(result.ofAssimp, m, texture, texture >= 0 && replaces ? 1 : opacity);
        result.uvChannel.push_back(uvChannel);
    }
    builder.scene.notes.add(textures.notes);
    builder.scene.textures = std::move(textures.textures);
    return result;
}

}  // namespace dapple::scenegen
