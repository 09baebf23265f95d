#include "scenegen/import/texture_files.h"

#include "base/error.h"
#include "scenegen/import/file_access.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace dapple::scenegen {
namespace fs = std::filesystem;
namespace {

std::string lower(std::string s) {
    std::ranges::transform(s, s.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    return s;
}

/// `path` below `folder`, where each part is found without regard to case; empty when there is none.
fs::path withoutCase(fs::path folder, const fs::path& path) {
    for (const fs::path& part : path) {
        std::error_code error;
        if (fs::exists(folder / part, error)) {
            folder /= part;
            continue;
        }
        std::set<fs::path> found;
        for (const auto& entry : fs::directory_iterator(folder, error))
            if (lower(entry.path().filename().string()) == lower(part.string())) found.insert(entry.path());
        if (found.empty()) return {};
        folder = *found.begin();
    }
    return folder;
}

size_t holes(const base::Image8& image, float cutoff) {
    size_t count = 0;
    for (size_t i = 3; i < image.texels.size(); i += 4) count += float(image.texels[i]) < cutoff * 255;
    return count;
}

bool hasHoles(const base::Image8& image, float cutoff) { return holes(image, cutoff) * 1000 > image.texels.size() / 4; }

/// As large as the larger of both in each direction, so that the mask keeps its edges.
base::Image8 masked(const base::Image8& colour, const base::Image8& mask, char channel) {
    if (channel == 0) channel = hasHoles(mask, kAlphaCutoff) ? 'm' : 'l';
    base::Image8 out{std::max(colour.width, mask.width), std::max(colour.height, mask.height), 4, {}};
    out.texels.reserve(size_t(out.width) * size_t(out.height) * 4);
    const auto texel = [&](const base::Image8& image, int x, int y) {
        return image.at(int(int64_t(x) * image.width / out.width), int(int64_t(y) * image.height / out.height));
    };
    for (int y = 0; y < out.height; ++y)
        for (int x = 0; x < out.width; ++x) {
            const uint8_t *c = texel(colour, x, y), *m = texel(mask, x, y);
            const uint8_t opacity = channel == 'r'   ? m[0]
                                    : channel == 'g' ? m[1]
                                    : channel == 'b' ? m[2]
                                    : channel == 'm' ? m[3]
                                                     : uint8_t((m[0] + m[1] + m[2] + 1) / 3);
            out.texels.insert(out.texels.end(), {c[0], c[1], c[2], opacity});
        }
    return out;
}

}  // namespace

fs::path findFile(const std::vector<fs::path>& folders, std::string name, Notes& notes) {
    std::ranges::replace(name, '\\', '/');
    if (name.starts_with("//")) name.erase(0, 2);  // Blender's mark of a path relative to the file
    const fs::path path(name);
    bool outside = false;
    std::error_code error;
    const auto isThere = [&](const fs::path& folder, const fs::path& candidate) {
        if (candidate.empty() || !fs::is_regular_file(candidate, error)) return false;
        const bool allowed = mayRead(folder, candidate);
        outside = outside || !allowed;
        return allowed;
    };
    for (const fs::path& folder : folders)
        for (const fs::path& wanted : {path, path.filename()})
            if (isThere(folder, folder / wanted)) return folder / wanted;
    for (const fs::path& folder : folders)
        for (const fs::path& wanted : {path.relative_path(), path.filename()})
            if (const fs::path found = withoutCase(folder, wanted); isThere(folder, found)) return found;
    if (outside) notes.add("files outside the scene's folder are not read (--allow-outside reads them)", name);
    return {};
}

TextureFiles::TextureFiles(const fs::path& file, const Sidecar& sidecar) : budget_(file) {
    folders_.push_back(file.parent_path().empty() ? fs::path(".") : file.parent_path());
    folders_.insert(folders_.end(), sidecar.textures.begin(), sidecar.textures.end());
}

int TextureFiles::load(const Request& request) {
    const bool ownAlpha = request.opacity.empty() || (request.opacity == request.colour && request.channel == 0);
    const std::string key =
        fmt::format("{}\n{}\n{}{}{}{}", request.colour, ownAlpha ? "" : request.opacity, int(request.channel),
                    int(request.wrapU), int(request.wrapV), request.folder.string());
    if (const auto it = index_.find(key); it != index_.end()) return it->second;
    int& index = index_[key];
    index = -1;
    const std::string& name = request.colour.empty() ? request.opacity : request.colour;
    auto image = request.colour.empty() ? base::Image8{1, 1, 4, {255, 255, 255, 255}} : read(name, request.folder);
    if (!image) return -1;
    if (const auto mask = ownAlpha ? std::nullopt : read(request.opacity, request.folder)) {
        budget_.texels(size_t(std::max(image->width, mask->width)), size_t(std::max(image->height, mask->height)));
        image = masked(*image, *mask, request.channel);
    } else if (request.colour.empty()) {
        return -1;
    }
    index = int(textures.size());
    textures.push_back({name, std::move(*image), request.wrapU, request.wrapV});
    return index;
}

std::optional<base::Image8> TextureFiles::read(const std::string& name, const fs::path& folder) {
    std::vector<fs::path> folders = folders_;
    if (!folder.empty()) folders.insert(folders.begin(), folder);
    std::optional<base::Image8> image;
    try {
        if (embedded) image = embedded(name);
        if (!image) {
            const fs::path path = findFile(folders, name, notes);
            if (path.empty()) {
                notes.add("textures are not found, and their materials have flat colours without holes", name);
                return std::nullopt;
            }
            image = base::readImage(path);
        }
    } catch (const base::UsageError&) {
        constexpr const char* kWhy = "textures are damaged or of no format that is read, and their materials have ";
        notes.add(std::string(kWhy) + "flat colours without holes", name);
        return std::nullopt;
    }
    budget_.texels(size_t(image->width), size_t(image->height));
    return image;
}

bool setOpacity(Material& material, const std::vector<Texture>& textures, int texture, float factor, float cutoff) {
    if (!(factor >= cutoff)) return false;
    material.texture = texture;
    material.alphaCutoff = cutoff / factor;
    material.alphaTested = texture >= 0 && hasHoles(textures[size_t(texture)].image, material.alphaCutoff);
    return true;
}

void noteOpacity(Notes& notes, float factor, const std::string& material) {
    if (factor > 0 && factor < 1)
        notes.add("opacities are cut at one half: what is fainter is not drawn, the rest is solid", material);
}

float linearFromSrgb(float v) { return v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f); }

}  // namespace dapple::scenegen
