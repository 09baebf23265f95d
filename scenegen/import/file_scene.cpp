#include "scenegen/import/file_scene.h"

#include "base/error.h"
#include "base/hash.h"
#include "scenegen/import/normals.h"

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

/// Rotation that takes the file's up axis to z. Entries are 0 and ±1: nothing is rounded.
glm::dmat3 zUpFrom(char up) {
    if (up == 'x') return {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}};
    if (up == 'y') return {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}};
    return glm::dmat3(1);
}

class Reader {
public:
    Reader(const fs::path& file, const Sidecar& sidecar)
        : file_(file), sidecar_(sidecar), axes_(zUpFrom(sidecar.up.value_or(defaultUp(file)))) {}

    FileScene read() {
        const aiScene& scene = load();
        const FileMaterials materials = readFileMaterials(scene, file_, sidecar_);
        result_.textures = materials.textures;
        result_.materials = materials.materials;
        result_.notes = materials.notes;
        for (unsigned i = 0; i < scene.mNumMeshes; ++i) addMesh(convert(*scene.mMeshes[i], materials));
        visit(*scene.mRootNode, glm::dmat4(1), true);
        for (const Sidecar::Copy& copy : sidecar_.copies)
            if (!worldFromNode_.contains(copy.node)) fail(fmt::format("its .toml copies node '{}', which does not exist", copy.node));
        readCameras(scene);
        readSun(scene);
        return std::move(result_);
    }

private:
    [[noreturn]] void fail(const std::string& why) const { throw base::UsageError(file_.string() + ": " + why); }

    const aiScene& load() {
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
        requireFinite(*scene, *scene->mRootNode);
        scene = importer_.ApplyPostProcessing(aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_TransformUVCoords |
                                              aiProcess_JoinIdenticalVertices | aiProcess_FlipUVs);
        if (!scene || scene->mNumMeshes == 0) fail("has no triangle");
        return *scene;
    }

    void requireFinite(const aiScene& scene, const aiNode& node) const {
        if (!base::allFinite(toGlm(node.mTransformation))) fail(fmt::format("node '{}' has a transform that is not finite", node.mName.C_Str()));
        for (unsigned i = 0; i < node.mNumMeshes; ++i) {
            const aiMesh& mesh = *scene.mMeshes[node.mMeshes[i]];
            for (unsigned v = 0; v < mesh.mNumVertices; ++v)
                if (!base::allFinite(toGlm(mesh.mVertices[v]))) fail(fmt::format("node '{}': vertex {} is not finite", node.mName.C_Str(), v));
        }
        for (unsigned i = 0; i < node.mNumChildren; ++i) requireFinite(scene, *node.mChildren[i]);
    }

    Mesh convert(const aiMesh& source, const FileMaterials& materials) const {
        Mesh mesh;
        const unsigned uvChannel = materials.uvChannel[source.mMaterialIndex];
        const bool hasUv = source.HasTextureCoords(uvChannel);
        mesh.material = (hasUv ? materials.ofAssimp : materials.flatOfAssimp)[source.mMaterialIndex];
        const bool textured = materials.materials[mesh.material].texture >= 0;
        for (unsigned v = 0; v < source.mNumVertices; ++v) {
            mesh.positions.emplace_back(sidecar_.unit * (axes_ * toGlm(source.mVertices[v])));
            const glm::dvec3 n = source.HasNormals() ? axes_ * toGlm(source.mNormals[v]) : glm::dvec3(0);
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

    /// Formats without shared meshes (and Assimp's Blender reader) copy a mesh for every node: equal ones
    /// are found again by content.
    void addMesh(Mesh mesh) {
        base::Hasher h;
        h.array(std::span<const glm::vec3>(mesh.positions));
        h.array(std::span<const uint32_t>(mesh.indices));
        const auto same = [&](const Mesh& m) {
            return m.positions == mesh.positions && m.indices == mesh.indices && m.normals == mesh.normals && m.uvs == mesh.uvs &&
                   m.material == mesh.material;
        };
        std::vector<uint32_t>& candidates = meshesByHash_[h.digest()];
        const auto it = std::ranges::find_if(candidates, [&](uint32_t i) { return same(result_.meshes[i]); });
        if (it != candidates.end()) {
            ourMesh_.push_back(*it);
            return;
        }
        ourMesh_.push_back(uint32_t(result_.meshes.size()));
        candidates.push_back(ourMesh_.back());
        result_.meshes.push_back(std::move(mesh));
    }

    /// A transform between file spaces as one between ours: positions are turned and scaled on both sides.
    glm::dmat4 conjugate(const glm::dmat4& m) const {
        glm::dmat4 r(axes_ * glm::dmat3(m) * glm::transpose(axes_));
        r[3] = glm::dvec4(sidecar_.unit * (axes_ * glm::dvec3(m[3])), 1);
        return r;
    }

    void visit(const aiNode& node, const glm::dmat4& worldFromParent, bool castsShadow) {
        const std::string name = node.mName.C_Str();
        castsShadow = castsShadow && !matchesAny(name, sidecar_.receivers);
        const glm::dmat4 world = worldFromParent * toGlm(node.mTransformation);
        worldFromNode_.emplace(name, world);
        if (node.mNumMeshes > 0) {
            FileScene::Object object{name, conjugate(world), {}, castsShadow};
            for (unsigned i = 0; i < node.mNumMeshes; ++i) object.meshes.push_back(ourMesh_[node.mMeshes[i]]);
            for (const Sidecar::Copy& copy : sidecar_.copies) {
                if (copy.node != name) continue;
                result_.objects.push_back(object);
                glm::dmat4& m = result_.objects.back().worldFromObject;
                m = glm::rotate(glm::dmat4(1), glm::radians(copy.yaw), glm::dvec3(0, 0, 1)) * glm::dmat4(glm::dmat3(m));
                m[3] = glm::dvec4(copy.to, 1);
            }
            if (!matchesAny(name, sidecar_.drop)) result_.objects.push_back(std::move(object));
        }
        for (unsigned i = 0; i < node.mNumChildren; ++i) visit(*node.mChildren[i], world, castsShadow);
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
            const auto node = worldFromNode_.find(camera.mName.C_Str());
            if (node == worldFromNode_.end()) continue;
            View view;
            view.name = camera.mName.length > 0 ? camera.mName.C_Str() : fmt::format("camera{}", i);
            // Assimp's glTF reader repeats the node's translation in the camera.
            const glm::dvec3 inNode = isGltf(file_) ? glm::dvec3(0) : toGlm(camera.mPosition);
            view.eye = sidecar_.unit * (axes_ * glm::dvec3(node->second * glm::dvec4(inNode, 1)));
            view.forward = axes_ * glm::dmat3(node->second) * toGlm(camera.mLookAt);
            view.up = axes_ * glm::dmat3(node->second) * toGlm(camera.mUp);
            if (!(glm::length(glm::cross(view.forward, view.up)) > 1e-9)) continue;
            view.forward = glm::normalize(view.forward);
            view.up = glm::normalize(view.up);
            const double fov = verticalFov(camera);
            if (fov > 1 && fov < 170) view.fovY = fov;  // Assimp 5.2 loses the angle of COLLADA: 0.8°
            view.far = 0;
            result_.views.push_back(view);
        }
    }

    void readSun(const aiScene& scene) {
        for (unsigned i = 0; i < scene.mNumLights && !result_.sun; ++i) {
            const aiLight& light = *scene.mLights[i];
            const auto node = worldFromNode_.find(light.mName.C_Str());
            if (light.mType != aiLightSource_DIRECTIONAL || node == worldFromNode_.end()) continue;
            const glm::dvec3 toSun = -(axes_ * glm::dmat3(node->second) * toGlm(light.mDirection));
            if (!(toSun.z > 1e-3 * glm::length(toSun))) continue;
            const double azimuth = glm::degrees(std::atan2(toSun.x, toSun.y));
            result_.sun = Sun{azimuth < 0 ? azimuth + 360 : azimuth, glm::degrees(std::asin(std::min(1.0, toSun.z / glm::length(toSun))))};
        }
    }

    fs::path file_;
    const Sidecar& sidecar_;
    glm::dmat3 axes_;
    Assimp::Importer importer_;
    std::map<uint64_t, std::vector<uint32_t>> meshesByHash_;
    std::vector<uint32_t> ourMesh_;  ///< index into FileScene::meshes, per Assimp mesh
    std::map<std::string, glm::dmat4> worldFromNode_;
    FileScene result_;
};

}  // namespace

FileScene readFileScene(const fs::path& file, const Sidecar& sidecar) { return Reader(file, sidecar).read(); }

}  // namespace dapple::scenegen
