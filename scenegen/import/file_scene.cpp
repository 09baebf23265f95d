#include "scenegen/import/file_scene.h"

#include "scenegen/import/normals.h"
#include "scenegen/import/scene_builder.h"

#include <assimp/Importer.hpp>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace dapple::scenegen {
namespace fs = std::filesystem;
namespace {

glm::dmat4 toGlm(const aiMatrix4x4& m) {
    return glm::transpose(glm::dmat4(m.a1, m.a2, m.a3, m.a4, m.b1, m.b2, m.b3, m.b4, m.c1, m.c2, m.c3, m.c4, m.d1, m.d2, m.d3, m.d4));
}

glm::dvec3 toGlm(const aiVector3D& v) { return {v.x, v.y, v.z}; }

constexpr double kCreaseDegrees = 45;  ///< where a file has no normals; AC3D's default crease angle

char defaultUp(const fs::path& file) {
    const std::string extension = lowerExtension(file);
    return extension == ".blend" || extension == ".stl" || extension == ".ply" ? 'z' : 'y';
}

bool isGltf(const fs::path& file) { return lowerExtension(file).starts_with(".gl"); }

class Reader {
public:
    Reader(const fs::path& file, const Sidecar& sidecar) : file_(file), sidecar_(sidecar), builder_(file, sidecar, defaultUp(file)) {}

    FileScene read() {
        const aiScene& scene = load();
        const FileMaterials materials = readFileMaterials(scene, file_, sidecar_);
        builder_.scene.textures = materials.textures;
        builder_.scene.materials = materials.materials;
        builder_.scene.notes = materials.notes;
        for (unsigned i = 0; i < scene.mNumMeshes; ++i) ourMesh_.push_back(builder_.addMesh(convert(*scene.mMeshes[i], materials)));
        readNodes(*scene.mRootNode);
        readCameras(scene);
        readSun(scene);
        return builder_.finish();
    }

private:
    const aiScene& load() {
        const auto fail = [&](const std::string& why) { builder_.fail(why); };
        std::error_code error;
        if (!fs::exists(file_, error)) fail("no such file");
        if (fs::is_directory(file_, error)) fail("is a folder, not a scene");
        if (fs::file_size(file_, error) == 0) fail("is empty");
        importer_.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
        importer_.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);
        const aiScene* scene = importer_.ReadFile(file_.string(), 0);
        if (!scene) {
            std::string why = importer_.GetErrorString();
            fail("cannot be read as a scene: " + why.substr(0, why.find('\n')));
        }
        if (!scene->mRootNode || scene->mNumMeshes == 0) fail("has no mesh");
        // Before any processing: it must not hide what is not finite.
        requireFinite(*scene);
        scene = importer_.ApplyPostProcessing(aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_TransformUVCoords |
                                              aiProcess_JoinIdenticalVertices | aiProcess_FlipUVs);
        if (!scene || scene->mNumMeshes == 0) fail("has no triangle");
        return *scene;
    }

    /// Nodes in the order in which a recursion meets them, without its depth.
    template <class Visit>
    static void forEachNode(const aiNode& root, const Visit& visit) {
        std::vector<const aiNode*> stack{&root};
        while (!stack.empty()) {
            const aiNode& node = *stack.back();
            stack.pop_back();
            visit(node);
            for (unsigned i = node.mNumChildren; i-- > 0;) stack.push_back(node.mChildren[i]);
        }
    }

    void requireFinite(const aiScene& scene) const {
        forEachNode(*scene.mRootNode, [&](const aiNode& node) {
            if (!base::allFinite(toGlm(node.mTransformation))) builder_.fail(fmt::format("node '{}' has a transform that is not finite", node.mName.C_Str()));
            for (unsigned i = 0; i < node.mNumMeshes; ++i) {
                const aiMesh& mesh = *scene.mMeshes[node.mMeshes[i]];
                for (unsigned v = 0; v < mesh.mNumVertices; ++v)
                    if (!base::allFinite(toGlm(mesh.mVertices[v]))) builder_.fail(fmt::format("node '{}': vertex {} is not finite", node.mName.C_Str(), v));
            }
        });
    }

    Mesh convert(const aiMesh& source, const FileMaterials& materials) const {
        Mesh mesh;
        const unsigned uvChannel = materials.uvChannel[source.mMaterialIndex];
        const bool hasUv = source.HasTextureCoords(uvChannel);
        mesh.material = (hasUv ? materials.ofAssimp : materials.flatOfAssimp)[source.mMaterialIndex];
        const bool textured = materials.materials[mesh.material].texture >= 0;
        for (unsigned v = 0; v < source.mNumVertices; ++v) {
            mesh.positions.emplace_back(builder_.position(toGlm(source.mVertices[v])));
            const glm::dvec3 n = source.HasNormals() ? builder_.direction(toGlm(source.mNormals[v])) : glm::dvec3(0);
            mesh.normals.emplace_back(base::allFinite(n) ? n : glm::dvec3(0));
            if (!textured) continue;
            const aiVector3D& t = source.mTextureCoords[uvChannel][v];
            const bool finite = std::isfinite(t.x) && std::isfinite(t.y);
            mesh.uvs.emplace_back(finite ? t.x : 0.0f, finite ? t.y : 0.0f);
        }
        for (unsigned f = 0; f < source.mNumFaces; ++f) {
            const aiFace& face = source.mFaces[f];
            if (face.mNumIndices == 3) mesh.indices.insert(mesh.indices.end(), face.mIndices, face.mIndices + 3);
        }
        // Not Assimp's: it does not split shared vertices at creases.
        if (!source.HasNormals()) generateNormals(mesh, kCreaseDegrees);
        return mesh;
    }

    void readNodes(const aiNode& root) {
        std::map<const aiNode*, SceneBuilder::Node> ours;
        forEachNode(root, [&](const aiNode& node) {
            const SceneBuilder::Node& here = ours[&node] =
                builder_.child(node.mParent ? ours[node.mParent] : SceneBuilder::Node{}, node.mName.C_Str(), toGlm(node.mTransformation));
            nodes_.emplace(here.name, here);
            if (node.mNumMeshes == 0) return;
            std::vector<uint32_t> meshes;
            for (unsigned i = 0; i < node.mNumMeshes; ++i) meshes.push_back(ourMesh_[node.mMeshes[i]]);
            builder_.addObject(here, std::move(meshes));
        });
    }

    /// Degrees.
    double verticalFov(const aiCamera& camera) const {
        const double aspect = double(camera.mAspect), horizontal = double(camera.mHorizontalFOV);
        // Assimp's glTF reader stores yfov · aspect as the "horizontal" angle.
        if (isGltf(file_)) return glm::degrees(aspect > 0 ? horizontal / aspect : horizontal);
        return glm::degrees(2 * std::atan(std::tan(horizontal / 2) / (aspect > 0 ? aspect : 4.0 / 3.0)));
    }

    void readCameras(const aiScene& scene) {
        for (unsigned i = 0; i < scene.mNumCameras; ++i) {
            const aiCamera& camera = *scene.mCameras[i];
            const auto node = nodes_.find(camera.mName.C_Str());
            if (node == nodes_.end()) continue;
            const std::string name = camera.mName.length > 0 ? camera.mName.C_Str() : fmt::format("camera{}", i);
            // Assimp's glTF reader repeats the node's translation in the camera.
            const glm::dvec3 eye = isGltf(file_) ? glm::dvec3(0) : toGlm(camera.mPosition);
            builder_.addView(node->second, name, eye, toGlm(camera.mLookAt), toGlm(camera.mUp), verticalFov(camera));
        }
    }

    void readSun(const aiScene& scene) {
        for (unsigned i = 0; i < scene.mNumLights; ++i) {
            const aiLight& light = *scene.mLights[i];
            const auto node = nodes_.find(light.mName.C_Str());
            if (light.mType == aiLightSource_DIRECTIONAL && node != nodes_.end()) builder_.addSun(node->second, toGlm(light.mDirection));
        }
    }

    fs::path file_;
    const Sidecar& sidecar_;
    SceneBuilder builder_;
    Assimp::Importer importer_;
    std::vector<uint32_t> ourMesh_;  ///< index into FileScene::meshes, per Assimp mesh
    std::map<std::string, SceneBuilder::Node> nodes_;
};

}  // namespace

FileScene readFileScene(const fs::path& file, const Sidecar& sidecar) { return Reader(file, sidecar).read(); }

}  // namespace dapple::scenegen
