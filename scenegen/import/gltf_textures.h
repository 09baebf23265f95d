#pragma once

#include "scenegen/import/gltf_document.h"
#include "scenegen/scene.h"

#include <filesystem>
#include <map>
#include <string>
#include <tuple>
#include <vector>

namespace dapple::scenegen {

/// The textures of a document that are asked for, each decoded once.
class GltfTextures {
public:
    /// Pictures that are not beside the file are looked for in `folders`.
    GltfTextures(GltfDocument& document, std::vector<std::filesystem::path> folders);

    /// Index into `textures` of a texture of the document; -1: it cannot be found or decoded, which is noted.
    int load(size_t texture);

    std::vector<Texture> textures;

private:
    int image(size_t index, Wrap u, Wrap v);
    std::string bytesOf(const Json& image);

    GltfDocument& document_;
    std::vector<std::filesystem::path> folders_;
    std::map<std::tuple<size_t, Wrap, Wrap>, int> known_;
};

}  // namespace dapple::scenegen
