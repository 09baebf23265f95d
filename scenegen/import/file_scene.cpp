#include "scenegen/import/file_scene.h"

#include "base/error.h"
#include "scenegen/import/assimp_files.h"
#include "scenegen/import/file_space.h"
#include "scenegen/import/normals.h"
#include "scenegen/import/obj_file.h"
#include "scenegen/import/ply_file.h"
#include "scenegen/import/polygons.h"
#include "scenegen/import/scene_builder.h"

#include <assimp/Importer.hpp>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <span>

namespace dapple::scenegen {
namespace fs = std::filesystem;
namespace {

glm::dmat4 toGlm(const aiMatrix4x4& m) {
    return glm::transpose(glm::dmat4(m.a1, m.a2, m.a3, m.a4, m.b1, m.b2, m.b3, m.b4, m.c1, m.c2, m.c3, m.c4, m.d1, m.d2, m.d3, m.d4));
}

glm::dvec3 toGlm(const aiVector3D& v) { return {v.x, v.y, v.z}; }

/// Nodes in the order in which a recursion meets them, without its depth.
template <class Visit>
void forEachNode(const aiNode& root, const Visit& visit) {
    std::vector<const aiNode*> stack{&root};
    while (!stack.empty()) {
        const aiNode& node = *stack.back();
        stack.pop_back();
        visit(node);
        for (unsigned i = node.mNumChildren; i-- > 0;)
            if (node.mChildren[i]) stack.push_back(node.mChildren[i]);
    }
}

[[noreturn]] void fail(const fs::path& file, const std::string& why) { throw base::UsageError(file.string() + ": " + why); }

/// Before any processing, which must not hide what is not finite, and trusts indices.
void requireSound(const fs::path& file, const aiScene& scene) {
    std::vector<std::string> wrong(scene.mNumMeshes);
    for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
        const aiMesh& mesh = *scene.mMeshes[m];
        for (unsigned v = 0; v < mesh.mNumVertices; ++v)
            if (!base::allFinite(toGlm(mesh.mVertices[v]))) wrong[m] = fmt::format("vertex {} is not finite", v);
        for (unsigned f = 0; f < mesh.mNumFaces; ++f)
            for (unsigned k = 0; k < mesh.mFaces[f].mNumIndices; ++k)
                if (mesh.mFaces[f].mIndices[k] >= mesh.mNumVertices)
                    wrong[m] = fmt::format("a face names vertex {} of {}", mesh.mFaces[f].mIndices[k], mesh.mNumVertices);
    }
    forEachNode(*scene.mRootNode, [&](const aiNode& node) {
        if (!base::allFinite(toGlm(node.mTransformation))) fail(file, fmt::format("node '{}' has a transform that is not finite", node.mName.C_Str()));
        for (unsigned i = 0; i < node.mNumMeshes; ++i)
            if (const std::string& why = wrong[node.mMeshes[i]]; !why.empty()) fail(file, fmt::format("node '{}': {}", node.mName.C_Str(), why));
    });
}

const aiScene& load(Assimp::Importer& importer, const fs::path& file) {
    importer.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);
    const aiScene* scene = importer.ReadFile(file.string(), 0);
    if (!scene) {
        const std::string why = importer.GetErrorString();
        fail(file, "cannot be read as a scene: " + why.substr(0, why.find('\n')));
    }
    if (!scene->mRootNode || scene->mNumMeshes == 0) fail(file, "has no mesh");
    requireSound(file, *scene);
    scene = importer.ApplyPostProcessing(aiProcess_TransformUVCoords | aiProcess_JoinIdenticalVertices | aiProcess_FlipUVs);
    if (!scene || scene->mNumMeshes == 0) fail(file, "has no triangle");
    return *scene;
}

class Reader {
public:
    Reader(const fs::path& file, const Sidecar& sidecar, const aiScene& scene)
        : builder_(file, sidecar, spaceOf(scene, file, notes_)),
          scene_(scene),
          materials_(readFileMaterials(scene, file, sidecar, builder_)) {
        builder_.scene.notes.add(notes_);
    }

    FileScene read() {
        for (unsigned i = 0; i < scene_.mNumMeshes; ++i) ourMesh_.push_back(addMesh(*scene_.mMeshes[i]));
        readNodes();
        readCameras();
        readSun();
        return builder_.finish();
    }

private:
    /// Index into FileScene::meshes; -1 when nothing of it is drawn.
    int addMesh(const aiMesh& source) {
        const unsigned uvChannel = materials_.uvChannel[source.mMaterialIndex];
        const bool hasUv = source.HasTextureCoords(uvChannel);
        const int material = (hasUv ? materials_.ofAssimp : materials_.flatOfAssimp)[source.mMaterialIndex];
        return material >= 0 ? int(builder_.addMesh(convert(source, uint32_t(material), uvChannel))) : -1;
    }

    Mesh convert(const aiMesh& source, uint32_t material, unsigned uvChannel) {
        Mesh mesh;
        mesh.material = material;
        const bool textured = builder_.scene.materials[material].texture >= 0;
        for (unsigned v = 0; v < source.mNumVertices; ++v) {
            mesh.positions.emplace_back(builder_.position(toGlm(source.mVertices[v])));
            const glm::dvec3 n = source.HasNormals() ? builder_.direction(toGlm(source.mNormals[v])) : glm::dvec3(0);
            mesh.normals.emplace_back(base::allFinite(n) ? n : glm::dvec3(0));
            if (!textured) continue;
            const aiVector3D& t = source.mTextureCoords[uvChannel][v];
            const bool finite = std::isfinite(t.x) && std::isfinite(t.y);
            mesh.uvs.emplace_back(finite ? t.x : 0.0f, finite ? t.y : 0.0f);
        }
        std::vector<glm::dvec3> polygon;
        std::vector<std::array<uint32_t, 3>> triangles;
        for (unsigned f = 0; f < source.mNumFaces; ++f) {
            const std::span<const unsigned> face(source.mFaces[f].mIndices, source.mFaces[f].mNumIndices);
            if (face.size() < 3) {
                builder_.scene.notes.add("lines and points are ignored");
                continue;
            }
            polygon.clear(), triangles.clear();
            for (const unsigned v : face) polygon.push_back(toGlm(source.mVertices[v]));
            if (!cutPolygon(polygon, triangles)) builder_.scene.notes.add(kCutAsFan, source.mName.C_Str());
            for (const auto& t : triangles)
                for (const uint32_t k : t) mesh.indices.push_back(face[k]);
        }
        // Not Assimp's: it does not split shared vertices at creases.
        if (!source.HasNormals()) generateNormals(mesh, kCreaseDegrees);
        return mesh;
    }

    void readNodes() {
        std::map<const aiNode*, SceneBuilder::Node> ours;
        forEachNode(*scene_.mRootNode, [&](const aiNode& node) {
            const SceneBuilder::Node& here = ours[&node] =
                builder_.child(node.mParent ? ours[node.mParent] : SceneBuilder::Node{}, node.mName.C_Str(), toGlm(node.mTransformation));
            nodes_.emplace(here.name, here);
            std::vector<uint32_t> meshes;
            for (unsigned i = 0; i < node.mNumMeshes; ++i)
                if (const int mesh = ourMesh_[node.mMeshes[i]]; mesh >= 0) meshes.push_back(uint32_t(mesh));
            if (meshes.empty()) return;
            // Assimp holds transforms as floats too.
            builder_.noteCoarse(here.name, glm::length(builder_.position(glm::dvec3(here.worldFromNode[3]))));
            builder_.addObject(here, std::move(meshes));
        });
    }

    /// Degrees.
    static double verticalFov(const aiCamera& camera) {
        const double aspect = double(camera.mAspect), horizontal = double(camera.mHorizontalFOV);
        return glm::degrees(2 * std::atan(std::tan(horizontal / 2) / (aspect > 0 ? aspect : 4.0 / 3.0)));
    }

    void readCameras() {
        for (unsigned i = 0; i < scene_.mNumCameras; ++i) {
            const aiCamera& camera = *scene_.mCameras[i];
            const auto node = nodes_.find(camera.mName.C_Str());
            if (node == nodes_.end()) continue;
            const std::string name = camera.mName.length > 0 ? camera.mName.C_Str() : fmt::format("camera{}", i);
            View lens;
            lens.fovY = verticalFov(camera);
            lens.far = 0;
            builder_.addView(node->second, name, toGlm(camera.mPosition), toGlm(camera.mLookAt), toGlm(camera.mUp), lens);
        }
    }

    void readSun() {
        for (unsigned i = 0; i < scene_.mNumLights; ++i) {
            const aiLight& light = *scene_.mLights[i];
            const auto node = nodes_.find(light.mName.C_Str());
            if (light.mType != aiLightSource_DIRECTIONAL || node == nodes_.end() || builder_.scene.sun) continue;
            builder_.scene.sun = builder_.sunOf(node->second, toGlm(light.mDirection));
        }
    }

    Notes notes_;  ///< of unit and axes
    SceneBuilder builder_;
    const aiScene& scene_;
    FileMaterials materials_;
    std::vector<int> ourMesh_;  ///< index into FileScene::meshes, per Assimp mesh; -1: not drawn
    std::map<std::string, SceneBuilder::Node> nodes_;
};

}  // namespace

FileScene readFileScene(const fs::path& file, const Sidecar& sidecar) {
    if (lowerExtension(file) == ".obj") return readObj(file, sidecar);
    if (lowerExtension(file) == ".ply") return readPly(file, sidecar);
    Notes notes;
    Assimp::Importer importer;
    importer.SetIOHandler(new AssimpFiles(file, notes));
    FileScene scene = Reader(file, sidecar, load(importer, file)).read();
    scene.notes.add(notes);
    return scene;
}

}  // namespace dapple::scenegen
