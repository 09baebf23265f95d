#include "scenegen/import/gltf_meshes.h"

#include "scenegen/import/gltf_accessors.h"
#include "scenegen/import/normals.h"

#include <fmt/format.h>

#include <algorithm>

// Khronos, "glTF 2.0 Specification" (2021), section 3.7.
namespace dapple::scenegen {
GltfMeshes::GltfMeshes(GltfDocument& document, const GltfMaterials& materials, SceneBuilder& builder)
    : document_(document), materials_(materials), builder_(builder) {}

const std::vector<uint32_t>& GltfMeshes::of(size_t mesh, const std::vector<double>& weights) {
    const auto [it, isNew] = known_.try_emplace({mesh, weights});
    if (isNew) it->second = read(mesh, weights, nullptr);
    return it->second;
}

std::vector<uint32_t> GltfMeshes::skinned(size_t mesh, const std::vector<double>& weights, const GltfPose& pose) { return read(mesh, weights, &pose); }

std::vector<double> GltfMeshes::weightsOf(const Json& node, size_t mesh) const {
    const Json& own = member(node, "weights");
    const Json& weights = own.is_null() ? member(document_.item("meshes", mesh), "weights") : own;
    return weights.is_null() ? std::vector<double>() : weights.get<std::vector<double>>();
}

std::vector<uint32_t> GltfMeshes::read(size_t index, const std::vector<double>& weights, const GltfPose* pose) {
    const Json& json = document_.item("meshes", index);
    const std::string name = valueOf<std::string>(json, "name", fmt::format("{}", index));
    std::vector<uint32_t> result;
    for (const Json& primitive : member(json, "primitives"))
        if (std::optional<Mesh> mesh = readPrimitive(primitive, name, weights, pose)) result.push_back(builder_.addMesh(std::move(*mesh)));
    return result;
}

template <class Vec>
void GltfMeshes::morph(std::vector<Vec>& values, const Json& primitive, const char* attribute, const std::vector<double>& weights) {
    const Json& targets = member(primitive, "targets");
    for (size_t t = 0; t < std::min(targets.size(), weights.size()); ++t) {
        if (weights[t] == 0 || !targets.at(t).contains(attribute)) continue;
        const auto offsets = asVectors<Vec>(readFloats(document_, document_.index(targets.at(t), attribute), size_t(Vec::length())));
        if (offsets.size() != values.size()) document_.fail(fmt::format("is damaged: a morph target has {} offsets for {} vertices", offsets.size(), values.size()));
        for (size_t i = 0; i < values.size(); ++i) values[i] += float(weights[t]) * offsets[i];
    }
}

/// Each vertex's weighted mean of its joints, over all sets of four (section 3.7.3.3).
std::vector<glm::dmat4> GltfMeshes::bonesOf(const GltfPrimitive& source, size_t vertices, const std::string& name, const GltfPose& pose) const {
    std::vector<glm::dmat4> bones(vertices, glm::dmat4(0));
    std::vector<double> sums(vertices, 0);
    for (size_t set = 0; source.has(fmt::format("JOINTS_{}", set)); ++set) {
        const auto joints = source.vectors<glm::vec4>(fmt::format("JOINTS_{}", set)), weights = source.vectors<glm::vec4>(fmt::format("WEIGHTS_{}", set));
        if (joints.size() != vertices || weights.size() != vertices) document_.fail(fmt::format("is damaged: mesh '{}' has not one joint and weight per vertex", name));
        for (size_t v = 0; v < vertices; ++v)
            for (int k = 0; k < 4; ++k) {
                const double weight = double(weights[v][k]);
                if (weight == 0) continue;
                const float joint = joints[v][k];
                if (!(joint >= 0 && joint < float(pose.worldFromBind.size())))
                    document_.fail(fmt::format("is damaged: mesh '{}' hangs on joint {}, which its skin does not have", name, joint));
                bones[v] += weight * pose.worldFromBind[size_t(joint)];
                sums[v] += weight;
            }
    }
    for (size_t v = 0; v < vertices; ++v) {
        if (!(std::abs(sums[v]) > 1e-6)) document_.fail(fmt::format("is damaged: vertex {} of the skinned mesh '{}' hangs on no joint", v, name));
        bones[v] /= sums[v];
    }
    return bones;
}

std::optional<Mesh> GltfMeshes::readPrimitive(const Json& primitive, const std::string& name, const std::vector<double>& weights, const GltfPose* pose) {
    document_.budget.time();
    const GltfPrimitive source(document_, primitive);
    auto positions = source.vectors<glm::vec3>("POSITION");
    const size_t vertices = positions.size();
    const auto sameCount = [&](size_t count, const char* what) {
        if (count != vertices) document_.fail(fmt::format("is damaged: mesh '{}' has {} {} for {} vertices", name, count, what, vertices));
    };
    Mesh mesh;
    mesh.indices = source.triangles(vertices);
    document_.budget.triangles(mesh.triangles());
    if (mesh.indices.empty()) {
        document_.notes.add("points, lines and empty primitives are left out", name);
        return {};
    }
    const GltfSurface& surface = materials_.surfaceOf(primitive);
    const std::string uvs = fmt::format("TEXCOORD_{}", surface.uvSet);
    const bool hasUvs = source.has(uvs);
    const int material = hasUvs ? surface.material : surface.flat;
    if (material < 0) {
        document_.notes.add("meshes that their material makes invisible are left out", name);
        return {};
    }
    mesh.material = uint32_t(material);
    if (surface.material != surface.flat && !hasUvs) document_.notes.add("textured meshes have no texture coordinates and become flat colours", name);
    if (source.has("COLOR_0")) document_.notes.add("colours of vertices are ignored", name);

    std::vector<glm::vec3> normals;
    if (source.has("NORMAL")) normals = source.vectors<glm::vec3>("NORMAL");
    else normals.assign(vertices, glm::vec3(0));
    sameCount(normals.size(), "normals");
    morph(positions, primitive, "POSITION", weights);
    morph(normals, primitive, "NORMAL", weights);
    const std::vector<glm::dmat4> bones = pose ? bonesOf(source, vertices, name, *pose) : std::vector<glm::dmat4>();
    for (size_t v = 0; v < vertices; ++v) {
        glm::dvec3 p(positions[v]), n(normals[v]);
        if (pose) {
            p = glm::dvec3(bones[v] * glm::dvec4(p, 1));
            n = glm::dmat3(bones[v]) * n;
        }
        if (!base::allFinite(glm::vec3(p))) document_.fail(fmt::format("vertex {} of mesh '{}' is not finite", v, name));
        mesh.positions.emplace_back(builder_.position(p));
        mesh.normals.emplace_back(base::allFinite(n) ? builder_.direction(n) : glm::dvec3(0));
    }
    if (builder_.scene.materials[mesh.material].texture >= 0) {
        for (const glm::vec2& uv : source.vectors<glm::vec2>(uvs)) {
            const glm::vec2 turned(surface.uvTransform * glm::dvec3(uv, 1));
            mesh.uvs.push_back(base::allFinite(turned) ? turned : glm::vec2(0));
        }
        sameCount(mesh.uvs.size(), "texture coordinates");
    }
    if (!source.has("NORMAL")) generateNormals(mesh, kCreaseDegrees);
    return mesh;
}

}  // namespace dapple::scenegen
