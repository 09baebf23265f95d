#pragma once

#include "scenegen/import/notes.h"
#include "scenegen/import/sidecar.h"
#include "scenegen/scene.h"

#include <filesystem>

struct aiScene;

namespace dapple::scenegen {

/// A scene file in our axes and units, before it is cut into prototypes.
struct FileScene {
    /// A node with meshes. worldFromObject maps mesh positions to the file's world (z up, metres).
    struct Object {
        std::string name;
        glm::dmat4 worldFromObject{1};
        std::vector<uint32_t> meshes;
        bool castsShadow = true;
    };
    std::vector<Texture> textures;
    std::vector<Material> materials;
    std::vector<Mesh> meshes;  ///< may hold degenerate triangles
    std::vector<Object> objects;
    std::vector<View> views;  ///< the file's cameras, eye in its world; far = 0: to be chosen
    Notes notes;              ///< what the file asks for and the reader does not do
    std::optional<Sun> sun;   ///< the file's first directional light that shines downwards
    std::vector<Sun> furtherSuns;  ///< the others, if the file says how strong each is
    /// A lamp, its position in the file's world.
    struct Lamp {
        glm::dvec3 position{0};
        LocalLight light;
    };
    std::vector<Lamp> lamps;
};

/// ".obj" of "A.OBJ".
std::string lowerExtension(const std::filesystem::path& file);

/// Reads `file`, which is no glTF. Throws the UsageErrors of importFile().
FileScene readFileScene(const std::filesystem::path& file, const Sidecar& sidecar);

class SceneBuilder;

/// Materials of an Assimp scene. -1: drawn nowhere.
struct FileMaterials {
    std::vector<int> ofAssimp;        ///< index into FileScene::materials, per Assimp material
    std::vector<int> flatOfAssimp;    ///< the same without texture, for meshes without coordinates
    std::vector<unsigned> uvChannel;  ///< texture coordinate set, per Assimp material
};
/// Adds materials and textures to the builder's scene.
FileMaterials readFileMaterials(const aiScene& scene, const std::filesystem::path& file, const Sidecar& sidecar, SceneBuilder& builder);

}  // namespace dapple::scenegen
