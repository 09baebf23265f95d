#include "base/error.h"
#include "scenegen/import/file_scene.h"

#include <assimp/material.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

namespace dapple::scenegen {
namespace fs = std::filesystem;
namespace {

/// IEC 61966-2-1, the sRGB transfer function.
float linearFromSrgb(float v) { return v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f); }

std::string lower(std::string s) {
    std::ranges::transform(s, s.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    return s;
}

/// A texture is a cut-out when more than one texel in a thousand is below the alpha cut-off: JPEG-like
/// noise and single stray texels do not count.
bool hasHoles(const base::Image8& image) {
    size_t holes = 0;
    for (size_t i = 3; i < image.texels.size(); i += 4) holes += image.texels[i] < 128;
    return holes * 1000 > image.texels.size() / 4;
}

class TextureStore {
public:
    TextureStore(const aiScene& scene, const fs::path& file, const Sidecar& sidecar) : scene_(scene) {
        folders_.push_back(file.parent_path().empty() ? fs::path(".") : file.parent_path());
        folders_.insert(folders_.end(), sidecar.textures.begin(), sidecar.textures.end());
    }

    /// Index of the texture whose colour is `colour` and whose alpha is `opacity` (empty: its own); -1 when
    /// it cannot be found or read.
    int load(const std::string& colour, const std::string& opacity) {
        const std::string key = opacity.empty() || opacity == colour ? colour : colour + "|" + opacity;
        if (const auto it = index_.find(key); it != index_.end()) return it->second;
        int& index = index_[key];
        index = -1;
        auto image = read(colour);
        if (!image) return -1;
        if (key != colour)
            if (const auto mask = read(opacity)) applyMask(*image, *mask);
        index = int(textures.size());
        textures.push_back({colour, std::move(*image)});
        return index;
    }

    std::vector<Texture> textures;
    std::set<std::string> missing;

private:
    std::optional<base::Image8> read(const std::string& name) {
        try {
            if (const aiTexture* embedded = scene_.GetEmbeddedTexture(name.c_str())) return decodeEmbedded(*embedded, name);
            const fs::path path = find(name);
            if (!path.empty()) return base::readImage(path);
        } catch (const base::UsageError&) {
            // An unreadable texture is booked like a missing one: the scene is still worth having.
        }
        missing.insert(name);
        return std::nullopt;
    }

    static base::Image8 decodeEmbedded(const aiTexture& texture, const std::string& name) {
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

    /// Files written on Windows or moved since: the path as it is, then its file name, in every folder,
    /// at last without regard to case.
    fs::path find(std::string name) const {
        std::ranges::replace(name, '\\', '/');
        if (name.starts_with("//")) name.erase(0, 2);  // Blender's mark of a path relative to the file
        const fs::path path(name);
        for (const fs::path& folder : folders_)
            for (const fs::path& candidate : {folder / path, folder / path.filename()})
                if (fs::is_regular_file(candidate)) return candidate;
        const std::string wanted = lower(path.filename().string());
        for (const fs::path& folder : folders_) {
            if (!fs::is_directory(folder)) continue;
            std::set<fs::path> found;
            for (const auto& entry : fs::directory_iterator(folder))
                if (entry.is_regular_file() && lower(entry.path().filename().string()) == wanted) found.insert(entry.path());
            if (!found.empty()) return *found.begin();
        }
        return {};
    }

    /// A mask carries opacity in its alpha if it has any, else in its grey level.
    static void applyMask(base::Image8& image, const base::Image8& mask) {
        const bool fromAlpha = hasHoles(mask);
        for (int y = 0; y < image.height; ++y)
            for (int x = 0; x < image.width; ++x) {
                const uint8_t* m = mask.at(x * mask.width / image.width, y * mask.height / image.height);
                image.at(x, y)[3] = fromAlpha ? m[3] : m[0];
            }
    }

    const aiScene& scene_;
    std::vector<fs::path> folders_;
    std::map<std::string, int> index_;
};

std::string texturePath(const aiMaterial& material, aiTextureType type, unsigned* uvChannel = nullptr) {
    aiString path;
    if (material.GetTexture(type, 0, &path, nullptr, uvChannel) != aiReturn_SUCCESS) return {};
    return path.C_Str();
}

Material flatMaterial(const aiMaterial& source, const std::string& extension) {
    const bool linearColours = extension.starts_with(".gl");
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
    for (int i = 0; i < 3; ++i) {
        const float v = std::clamp(diffuse[unsigned(i)], 0.0f, 1.0f);
        m.albedo[i] = linearColours ? v : linearFromSrgb(v);
    }
    if (hasHighlight && shininess >= 1) {  // below: no highlight that a pixel could show
        m.specular = std::clamp(strength * std::max({specular.r, specular.g, specular.b}), 0.0f, 1.0f);
        m.shininess = std::min(shininess, 1024.0f);
    }
    return m;
}

}  // namespace

std::string lowerExtension(const fs::path& file) { return lower(file.extension().string()); }

FileMaterials readFileMaterials(const aiScene& scene, const fs::path& file, const Sidecar& sidecar) {
    const std::string extension = lowerExtension(file);
    TextureStore store(scene, file, sidecar);
    FileMaterials result;
    using Key = std::tuple<float, float, float, float, float, int, bool>;
    std::map<Key, uint32_t> known;
    const auto add = [&](const Material& m) {
        const Key key{m.albedo.x, m.albedo.y, m.albedo.z, m.specular, m.shininess, m.texture, m.alphaTested};
        const auto [it, isNew] = known.emplace(key, uint32_t(result.materials.size()));
        if (isNew) result.materials.push_back(m);
        return it->second;
    };

    for (unsigned i = 0; i < scene.mNumMaterials; ++i) {
        const aiMaterial& source = *scene.mMaterials[i];
        Material m = flatMaterial(source, extension);
        result.flatOfAssimp.push_back(add(m));

        unsigned uvChannel = 0;
        std::string colour = texturePath(source, aiTextureType_BASE_COLOR, &uvChannel);
        if (colour.empty()) colour = texturePath(source, aiTextureType_DIFFUSE, &uvChannel);
        if (!colour.empty()) m.texture = store.load(colour, texturePath(source, aiTextureType_OPACITY));
        if (m.texture >= 0) {
            // Blender's old materials replace their colour by the texture, AC3D adds emission to it up to
            // white; and many exporters leave a textured material black.
            const bool replaces = extension == ".blend" || extension == ".ac" || extension == ".acc";
            if (replaces || std::max({m.albedo.r, m.albedo.g, m.albedo.b}) < 0.01f) m.albedo = glm::vec3(1);
            aiString mode;
            const bool opaque = extension.starts_with(".gl") && source.Get("$mat.gltf.alphaMode", 0, 0, mode) == aiReturn_SUCCESS &&
                                std::string(mode.C_Str()) == "OPAQUE";  // glTF 2.0 §3.9.4: alpha is ignored
            m.alphaTested = !opaque && hasHoles(store.textures[size_t(m.texture)].image);
        }
        result.ofAssimp.push_back(add(m));
        result.uvChannel.push_back(uvChannel);
    }
    for (const std::string& name : store.missing) result.notes.add("textures cannot be found or read and become flat colours", name);
    result.textures = std::move(store.textures);
    return result;
}

}  // namespace dapple::scenegen
