#include "scenegen/import/own_gltf.h"

#include "scenegen/export/glb.h"
#include "scenegen/import/gltf_accessors.h"
#include "scenegen/import/gltf_materials.h"
#include "scenegen/lod/connectivity.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace dapple::scenegen {
namespace {

template <class Vec>
Vec vec(const Json& array) {
    static_cast<void>(array.at(0));  // there must be one
    return vectorOf(array, Vec(0));
}

/// y up to z up, exactly.
glm::vec3 zUp(const glm::vec3& v) { return {v.x, -v.z, v.y}; }

class Reader {
public:
    Reader(GltfDocument& document, const Json& gltfScene)
        : document_(document), scene_(gltfScene), exact_(gltfScene.at("extras")), untouched_(valueOf<std::string>(document.root().at("asset"), "generator", "") == kGlbGenerator) {}

    /// Whether what the extras say of the rest of the file still holds.
    bool holds() const {
        const Json &instances = exact_.at("instances"), &prototypes = exact_.at("prototypes"), &materials = exact_.at("materials");
        if (document_.count("materials") != materials.size() || document_.count("cameras") != exact_.at("views").size()) return false;
        if (document_.count("nodes") < instances.size()) return false;
        for (size_t i = 0; i < materials.size(); ++i)
            if (std::abs(highlightOf(document_.item("materials", i)).shininess - materials.at(i).at(1).get<float>()) > 1e-3f * materials.at(i).at(1).get<float>() + 1e-3f) return false;
        for (size_t i = 0; i < instances.size(); ++i) {
            const Json &node = document_.item("nodes", i), &prototype = prototypes.at(instances.at(i).at(0).get<size_t>());
            if (valueOf(node, "mesh", -1) != prototype.at("mesh").get<int>() || node.contains("matrix") || node.contains("children") || node.contains("extensions")) return false;
            const auto turn = vectorOf(member(node, "rotation"), glm::dvec4(0, 0, 0, 1));
            const auto scale = vectorOf(member(node, "scale"), glm::dvec3(1));
            if (!(glm::length(scale - glm::dvec3(scale.x)) <= 1e-6 * std::abs(scale.x))) return false;
            const double half = 0.5 * instances.at(i).at(1).get<double>();
            // q and -q are one rotation.
            if (!(std::abs(std::abs(turn.y * std::sin(half) + turn.w * std::cos(half)) - 1) < 1e-6)) return false;
        }
        return true;
    }

    Scene read() {
        Scene scene;
        scene.name = valueOf<std::string>(scene_, "name", document_.file().stem().string());
        scene.source = document_.file().string();
        scene.origin = vec<glm::dvec3>(exact_.at("origin"));
        scene.sun = {exact_.at("sun").at(0).get<double>(), exact_.at("sun").at(1).get<double>()};
        for (const Json& s : member(exact_, "furtherSuns")) scene.furtherSuns.push_back({s.at(0).get<double>(), s.at(1).get<double>(), s.at(2).get<double>()});
        readMaterials(scene);
        for (const Json& p : exact_.at("prototypes")) scene.prototypes.push_back(readPrototype(p));
        for (size_t i = 0; i < exact_.at("instances").size(); ++i) {
            const Json &node = document_.item("nodes", i), &known = exact_.at("instances").at(i);
            scene.instances.push_back({zUp(vectorOf(member(node, "translation"), glm::vec3(0))), vectorOf(member(node, "scale"), glm::vec3(1)).x,
                                       known.at(1).get<float>(), known.at(0).get<uint32_t>()});
        }
        for (const Json& v : exact_.at("views"))
            scene.views.push_back({v.at("name").get<std::string>(), vec<glm::dvec3>(v.at("eye")), vec<glm::dvec3>(v.at("forward")), vec<glm::dvec3>(v.at("up")),
                                   v.at("fovY").get<double>(), v.at("near").get<double>(), v.at("far").get<double>()});
        for (const Json& l : exact_.at("lights"))
            scene.lights.push_back({vec<glm::vec3>(l.at("position")), vec<glm::vec3>(l.at("direction")), vec<glm::vec3>(l.at("intensity")),
                                    l.at("range").get<float>(), l.at("innerAngle").get<float>(), l.at("outerAngle").get<float>()});
        for (const Json& m : exact_.at("motions"))
            scene.motions.push_back({m.at("instance").get<uint32_t>(), vec<glm::vec3>(m.at("from")), vec<glm::vec3>(m.at("to")), m.at("speed").get<float>(), m.at("start").get<float>(),
                                     m.at("across").get<float>(), m.at("radius").get<float>()});
        return scene;
    }

private:
    void readMaterials(Scene& scene) {
        GltfTextures textures(document_, {});
        std::vector<int> ours;
        for (size_t t = 0; t < document_.count("textures"); ++t) {
            ours.push_back(textures.load(t));
            if (ours.back() < 0) document_.fail(fmt::format("is damaged: textures[{}] cannot be read", t));
        }
        scene.textures = std::move(textures.textures);
        for (size_t i = 0; i < document_.count("materials"); ++i) {
            const Json &j = document_.item("materials", i), &surface = j.at("pbrMetallicRoughness"), &highlight = exact_.at("materials").at(i);
            Material& m = scene.materials.emplace_back();
            m.name = valueOf<std::string>(j, "name", "");
            m.albedo = vectorOf(member(surface, "baseColorFactor"), glm::vec3(1));
            m.specular = highlight.at(0).get<float>();
            m.shininess = highlight.at(1).get<float>();
            if (surface.contains("baseColorTexture")) m.texture = ours.at(document_.index(surface["baseColorTexture"], "index"));
            m.alphaTested = valueOf<std::string>(j, "alphaMode", "OPAQUE") == "MASK";
            if (m.alphaTested) m.alphaCutoff = valueOf(j, "alphaCutoff", kAlphaCutoff);
            m.doubleSided = valueOf(j, "doubleSided", false);
        }
    }

    Prototype readPrototype(const Json& p) {
        Prototype prototype;
        prototype.name = p.at("name").get<std::string>();
        prototype.castsShadow = p.at("castsShadow").get<bool>();
        prototype.moving = p.at("moving").get<bool>();
        prototype.transmittance = valueOf(p, "transmittance", 0.0f);
        if (const int mesh = p.at("mesh").get<int>(); mesh >= 0)
            for (const Json& primitive : document_.item("meshes", size_t(mesh)).at("primitives")) prototype.meshes.push_back(readMesh(primitive));
        prototype.closed = untouched_ && !document_.root().contains("extensionsRequired") ? p.at("closed").get<bool>() : isClosed(prototype);
        return prototype;
    }

    Mesh readMesh(const Json& primitive) {
        const GltfPrimitive source(document_, primitive);
        Mesh mesh;
        mesh.positions = source.vectors<glm::vec3>("POSITION");
        mesh.normals = source.vectors<glm::vec3>("NORMAL");
        for (auto* values : {&mesh.positions, &mesh.normals})
            for (glm::vec3& v : *values) v = zUp(v);
        if (source.has("TEXCOORD_0")) mesh.uvs = source.vectors<glm::vec2>("TEXCOORD_0");
        mesh.indices = source.triangles(mesh.positions.size());
        document_.budget.triangles(mesh.triangles());
        mesh.material = uint32_t(document_.index(primitive, "material"));
        return mesh;
    }

    GltfDocument& document_;
    const Json& scene_;
    const Json& exact_;
    bool untouched_;  ///< by other programs, as far as it says
};

}  // namespace

std::optional<Scene> readOwnGltf(GltfDocument& document) {
    if (document.count("scenes") != 1) return {};
    const Json &scene = document.item("scenes", 0), &extras = member(scene, "extras");
    for (const char* key : {"origin", "sun", "prototypes", "instances", "materials", "views", "lights", "motions"})
        if (member(extras, key).is_null()) return {};
    try {
        Reader reader(document, scene);
        if (!reader.holds()) return {};
        return reader.read();
    } catch (const Json::exception& error) {
        document.fail("is damaged: " + reasonOf(error));
    }
}

}  // namespace dapple::scenegen
