#include "scenegen/texture_size.h"

#include "base/log.h"

#include <fmt/format.h>

#include <algorithm>

namespace dapple::scenegen {
namespace {

/// Mean of blocks of kx × ky texels. Colours count by their opacity: what cannot be seen must not tint an edge.
base::Image8 shrunk(const base::Image8& image, int kx, int ky) {
    base::Image8 out{(image.width + kx - 1) / kx, (image.height + ky - 1) / ky, 4, {}};
    out.texels.resize(size_t(out.width) * size_t(out.height) * 4);
    for (int y = 0; y < out.height; ++y)
        for (int x = 0; x < out.width; ++x) {
            size_t sum[3] = {}, plain[3] = {}, alpha = 0, count = 0;
            for (int v = y * ky; v < std::min((y + 1) * ky, image.height); ++v)
                for (int u = x * kx; u < std::min((x + 1) * kx, image.width); ++u, ++count) {
                    const uint8_t* t = image.at(u, v);
                    for (int c = 0; c < 3; ++c) sum[c] += size_t(t[c]) * t[3], plain[c] += t[c];
                    alpha += t[3];
                }
            uint8_t* t = out.at(x, y);
            for (int c = 0; c < 3; ++c) t[c] = uint8_t(alpha > 0 ? (sum[c] + alpha / 2) / alpha : (plain[c] + count / 2) / count);
            t[3] = uint8_t((alpha + count / 2) / count);
        }
    return out;
}

}  // namespace

void fitTextures(Scene& scene, int most) {
    for (Texture& texture : scene.textures) {
        base::Image8& image = texture.image;
        const int kx = (image.width + most - 1) / most, ky = (image.height + most - 1) / most;
        if (kx <= 1 && ky <= 1) continue;
        base::Image8 smaller = shrunk(image, kx, ky);
        scene.notes.push_back(fmt::format("texture '{}' of {}×{} texels is scaled to {}×{}: this GL takes {} a side", texture.name, image.width, image.height, smaller.width, smaller.height, most));
        base::logWarning(fmt::format("{}: {}", scene.name, scene.notes.back()));
        image = std::move(smaller);
    }
}

}  // namespace dapple::scenegen
