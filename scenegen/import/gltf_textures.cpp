#include "scenegen/import/gltf_textures.h"

#include "base/error.h"
#include "base/file.h"
#include "base/image.h"

#include <fmt/format.h>

#include <algorithm>

// Khronos, "glTF 2.0 Specification" (2021), section 3.8; EXT_texture_webp.
namespace dapple::scenegen {
namespace fs = std::filesystem;
namespace {

Wrap wrapOf(const GltfDocument& document, const Json& sampler, const char* key) {
    const size_t mode = document.indexOr(sampler, key, 10497);
    return mode == 33071 ? Wrap::clamp : mode == 33648 ? Wrap::mirror : Wrap::repeat;
}

}  // namespace

GltfTextures::GltfTextures(GltfDocument& document, std::vector<fs::path> folders) : document_(document), folders_(std::move(folders)) {}

int GltfTextures::load(size_t texture) {
    const Json& json = document_.item("textures", texture);
    const Json& sampler = json.contains("sampler") ? document_.item("samplers", document_.index(json, "sampler")) : member(json, "sampler");
    const Wrap u = wrapOf(document_, sampler, "wrapS"), v = wrapOf(document_, sampler, "wrapT");
    const Json& webp = extension(json, "EXT_texture_webp");
    if (!webp.is_null())
        if (const int t = image(document_.index(webp, "source"), u, v); t >= 0) return t;
    if (json.contains("source")) return image(document_.index(json, "source"), u, v);
    if (webp.is_null()) document_.notes.add("textures have pictures of a kind that is not read and become flat colours", fmt::format("textures[{}]", texture));
    return -1;
}

int GltfTextures::image(size_t index, Wrap u, Wrap v) {
    const auto [it, isNew] = known_.try_emplace({index, u, v}, -1);
    if (!isNew) return it->second;
    for (const auto& [key, known] : known_)  // the same picture, wrapped otherwise
        if (std::get<0>(key) == index && known >= 0) {
            const Texture& same = textures[size_t(known)];
            document_.budget.texels(size_t(same.image.width), size_t(same.image.height));
            textures.push_back({same.name, same.image, u, v});
            return it->second = int(textures.size() - 1);
        }
    const Json& json = document_.item("images", index);
    const std::string uri = valueOf<std::string>(json, "uri", "");
    std::string name = valueOf<std::string>(json, "name", "");
    if (name.empty()) name = uri.empty() || uri.starts_with("data:") ? fmt::format("images[{}]", index) : uri;
    try {
        const std::string bytes = bytesOf(json);
        base::Image8 picture = base::decodeImage({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()}, name);
        document_.budget.texels(size_t(picture.width), size_t(picture.height));
        textures.push_back({name, std::move(picture), u, v});
        it->second = int(textures.size() - 1);
    } catch (const base::UsageError&) {
        // The scene is still worth having without it.
        document_.notes.add("textures cannot be found or read and become flat colours", name);
    }
    return it->second;
}

std::string GltfTextures::bytesOf(const Json& image) {
    const Json& uri = member(image, "uri");
    if (uri.is_null()) {
        const std::span<const uint8_t> bytes = document_.view(document_.index(image, "bufferView"));
        return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    }
    for (const fs::path& folder : folders_) {
        const fs::path path = folder / fs::path(GltfDocument::fileName(uri.get<std::string>())).filename();
        if (std::error_code error; fs::is_regular_file(path, error)) return base::readFile(path);
    }
    return document_.fetch(uri.get<std::string>());
}

}  // namespace dapple::scenegen
