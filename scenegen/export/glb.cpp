#include "scenegen/export/glb.h"

#include "base/error.h"
#include "base/file.h"
#include "scenegen/gltf_highlight.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

// Khronos, "glTF 2.0 Specification" (2021), sections 3 and 4.
namespace dapple::scenegen {
namespace {
using Json = nlohmann::json;

constexpr int kFloat = 5126, kUint32 = 5125, kVertexBuffer = 34962, kIndexBuffer = 34963;
constexpr std::array kWraps{10497, 33071, 33648};  ///< in the order of Wrap

/// z up to y up: a quarter turn about x.
template <class Vec>
Vec yUp(const Vec& v) { return {v.x, v.z, -v.y}; }

template <class Vec>
Json toJson(const Vec& v) {
    Json array = Json::array();
    for (int i = 0; i < Vec::length(); ++i) array.push_back(v[i]);
    return array;
}

class GlbWriter {
public:
    explicit GlbWriter(const Scene& scene) : scene_(scene) {}

    std::string write() {
        root_["asset"] = {{"version", "2.0"}, {"generator", kGlbGenerator}};
        addMaterials();
        for (const Prototype& prototype : scene_.prototypes) addPrototype(prototype);
        Json children = Json::array();
        for (const Instance& instance : scene_.instances) children.push_back(addInstance(instance));
        for (const View& view : scene_.views) children.push_back(addCamera(view));
        root_["extensionsUsed"] = {"KHR_lights_punctual"};
        if (hasHighlights_) root_["extensionsUsed"].push_back("KHR_materials_specular");
        children.push_back(addSun(scene_.sun));
        for (const Sun& sun : scene_.furtherSuns) children.push_back(addSun(sun));
        for (const LocalLight& light : scene_.lights) children.push_back(addLight(light));
        root_["nodes"].push_back({{"name", "origin"}, {"translation", toJson(yUp(scene_.origin))}, {"children", children}});
        root_["scenes"] = {{{"name", scene_.name}, {"nodes", {root_["nodes"].size() - 1}}, {"extras", exactly()}}};
        root_["scene"] = 0;
        if (!buffer_.empty()) root_["buffers"] = {{{"byteLength", buffer_.size()}}};
        return pack();
    }

private:
    size_t addView(const void* data, size_t bytes, int target) {
        Json view = {{"buffer", 0}, {"byteOffset", buffer_.size()}, {"byteLength", bytes}};
        if (target != 0) view["target"] = target;
        buffer_.append(static_cast<const char*>(data), bytes);
        buffer_.resize((buffer_.size() + 3) / 4 * 4, '\0');
        root_["bufferViews"].push_back(view);
        return root_["bufferViews"].size() - 1;
    }

    template <class T>
    size_t addAccessor(const std::vector<T>& values, int component, const char* type, int target) {
        root_["accessors"].push_back({{"bufferView", addView(values.data(), values.size() * sizeof(T), target)},
                                      {"componentType", component}, {"count", values.size()}, {"type", type}});
        return root_["accessors"].size() - 1;
    }

    void addMaterials() {
        for (const Texture& texture : scene_.textures) {
            const std::string png = base::encodePng(texture.image);
            root_["images"].push_back({{"name", texture.name}, {"mimeType", "image/png"}, {"bufferView", addView(png.data(), png.size(), 0)}});
            root_["textures"].push_back({{"source", root_["images"].size() - 1}});
            if (texture.wrapU == Wrap::repeat && texture.wrapV == Wrap::repeat) continue;
            root_["samplers"].push_back({{"wrapS", kWraps[size_t(texture.wrapU)]}, {"wrapT", kWraps[size_t(texture.wrapV)]}});
            root_["textures"].back()["sampler"] = root_["samplers"].size() - 1;
        }
        for (const Material& m : scene_.materials) {
            Json surface = {{"baseColorFactor", {m.albedo.r, m.albedo.g, m.albedo.b, 1}}, {"metallicFactor", 0}, {"roughnessFactor", roughnessOf(m.shininess)}};
            if (m.texture >= 0) surface["baseColorTexture"] = {{"index", m.texture}};
            Json material = {{"name", m.name}, {"pbrMetallicRoughness", surface}, {"doubleSided", m.doubleSided}};
            if (m.alphaTested) material["alphaMode"] = "MASK", material["alphaCutoff"] = m.alphaCutoff;
            if (m.specular > 0) {
                const double strength = double(m.specular) / highlightScale(m.shininess);
                material["extensions"]["KHR_materials_specular"]["specularColorFactor"] = {strength, strength, strength};
                hasHighlights_ = true;
            }
            root_["materials"].push_back(material);
        }
    }

    void addPrototype(const Prototype& prototype) {
        Json primitives = Json::array();
        for (const Mesh& mesh : prototype.meshes) {
            if (mesh.indices.empty()) continue;  // glTF has no empty primitive
            std::vector<glm::vec3> positions, normals;
            base::Box box;
            for (const glm::vec3& p : mesh.positions) {
                positions.push_back(yUp(p));
                box.extend(positions.back());
            }
            for (const glm::vec3& n : mesh.normals) normals.push_back(yUp(n));
            Json attributes = {{"POSITION", addAccessor(positions, kFloat, "VEC3", kVertexBuffer)}};
            root_["accessors"].back()["min"] = toJson(box.lo);
            root_["accessors"].back()["max"] = toJson(box.hi);
            attributes["NORMAL"] = addAccessor(normals, kFloat, "VEC3", kVertexBuffer);
            if (!mesh.uvs.empty()) attributes["TEXCOORD_0"] = addAccessor(mesh.uvs, kFloat, "VEC2", kVertexBuffer);
            primitives.push_back({{"attributes", attributes}, {"material", mesh.material},
                                  {"indices", addAccessor(mesh.indices, kUint32, "SCALAR", kIndexBuffer)}});
        }
        meshOf_.push_back(primitives.empty() ? -1 : int(root_["meshes"].size()));
        if (!primitives.empty()) root_["meshes"].push_back({{"name", prototype.name}, {"primitives", primitives}});
        // Where other programs take the scene's extras for their own, a mesh keeps its mark.
        if (!primitives.empty() && !prototype.castsShadow) root_["meshes"].back()["extras"] = {{"castsShadow", false}};
    }

    /// What glTF has no word for, or only in rounded ones: with it the scene is read back to the bit.
    Json exactly() const {
        Json prototypes = Json::array(), instances = Json::array(), materials = Json::array(), views = Json::array(), lights = Json::array(), motions = Json::array();
        for (size_t i = 0; i < scene_.prototypes.size(); ++i) {
            const Prototype& p = scene_.prototypes[i];
            prototypes.push_back({{"name", p.name}, {"mesh", meshOf_[i]}, {"castsShadow", p.castsShadow}, {"closed", p.closed}, {"moving", p.moving}});
            if (p.transmittance > 0) prototypes.back()["transmittance"] = p.transmittance;
        }
        for (const Instance& i : scene_.instances) instances.push_back({i.prototype, i.yaw});
        for (const Material& m : scene_.materials) materials.push_back({m.specular, m.shininess});
        for (const View& v : scene_.views)
            views.push_back({{"name", v.name}, {"eye", toJson(v.eye)}, {"forward", toJson(v.forward)}, {"up", toJson(v.up)}, {"fovY", v.fovY}, {"near", v.near}, {"far", v.far}});
        for (const LocalLight& l : scene_.lights)
            lights.push_back({{"position", toJson(l.position)}, {"direction", toJson(l.direction)}, {"intensity", toJson(l.intensity)},
                              {"range", l.range}, {"innerAngle", l.innerAngle}, {"outerAngle", l.outerAngle}});
        for (const Motion& m : scene_.motions)
            motions.push_back({{"instance", m.instance}, {"from", toJson(m.from)}, {"to", toJson(m.to)}, {"speed", m.speed}, {"start", m.start}, {"across", m.across}, {"radius", m.radius}});
        Json exact = {{"origin", toJson(scene_.origin)}, {"sun", {scene_.sun.azimuth, scene_.sun.elevation}}, {"prototypes", prototypes},
                      {"instances", instances}, {"materials", materials}, {"views", views}, {"lights", lights}, {"motions", motions}};
        for (const Sun& s : scene_.furtherSuns) exact["furtherSuns"].push_back({s.azimuth, s.elevation, s.strength});
        return exact;
    }

    size_t addNode(Json node) {
        root_["nodes"].push_back(std::move(node));
        return root_["nodes"].size() - 1;
    }

    size_t addInstance(const Instance& instance) {
        const double half = 0.5 * double(instance.yaw);
        Json node = {{"name", scene_.prototypes[instance.prototype].name},
                     {"translation", toJson(yUp(instance.translation))},
                     {"rotation", {0.0, std::sin(half), 0.0, std::cos(half)}},
                     {"scale", {instance.scale, instance.scale, instance.scale}}};
        if (meshOf_[instance.prototype] >= 0) node["mesh"] = meshOf_[instance.prototype];
        return addNode(std::move(node));
    }

    /// A node at `eye` that looks along its own -z.
    static Json lookingNode(const std::string& name, const glm::dvec3& eye, const glm::dvec3& forward, const glm::dvec3& up) {
        const glm::dvec3 z = -yUp(forward), x = glm::normalize(glm::cross(yUp(up), z)), y = glm::cross(z, x), at = yUp(eye);
        return {{"name", name}, {"matrix", {x.x, x.y, x.z, 0, y.x, y.y, y.z, 0, z.x, z.y, z.z, 0, at.x, at.y, at.z, 1}}};
    }

    size_t addCamera(const View& view) {
        root_["cameras"].push_back({{"name", view.name}, {"type", "perspective"},
                                    {"perspective", {{"yfov", glm::radians(view.fovY)}, {"znear", view.near}, {"zfar", view.far}}}});
        Json node = lookingNode(view.name, view.eye, view.forward, view.up);
        node["camera"] = root_["cameras"].size() - 1;
        return addNode(std::move(node));
    }

    size_t addPunctual(Json light, Json node) {
        Json& lights = root_["extensions"]["KHR_lights_punctual"]["lights"];
        lights.push_back(std::move(light));
        node["extensions"]["KHR_lights_punctual"]["light"] = lights.size() - 1;
        return addNode(std::move(node));
    }

    size_t addSun(const Sun& sun) {
        const glm::dvec3 d = sun.direction();
        return addPunctual({{"name", "sun"}, {"type", "directional"}, {"intensity", sun.strength}}, lookingNode("sun", glm::dvec3(0), d, acrossOf(d)));
    }

    size_t addLight(const LocalLight& light) {
        const float strength = std::max({light.intensity.r, light.intensity.g, light.intensity.b, 1e-9f});
        Json entry = {{"type", "point"}, {"color", toJson(light.intensity / strength)}, {"intensity", strength}, {"range", light.range}};
        // A spot of the specification is at most a hemisphere.
        if (light.outerAngle <= float(std::numbers::pi / 2)) {
            entry["type"] = "spot";
            entry["spot"] = {{"innerConeAngle", light.innerAngle}, {"outerConeAngle", light.outerAngle}};
        }
        return addPunctual(std::move(entry), lookingNode("lamp", light.position, light.direction, acrossOf(light.direction)));
    }

    /// A direction that is not parallel to `d`.
    static glm::dvec3 acrossOf(const glm::dvec3& d) { return std::abs(d.z) > 0.99 ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1); }

    std::string pack() const {
        std::string json = root_.dump();
        json.resize((json.size() + 3) / 4 * 4, ' ');
        const size_t total = 12 + 8 + json.size() + (buffer_.empty() ? 0 : 8 + buffer_.size());
        if (total > std::numeric_limits<uint32_t>::max())
            throw base::UsageError(fmt::format("scene {}: {} bytes exceed the 4 GiB of a .glb", scene_.name, total));
        std::string file;
        file.reserve(total);
        const auto word = [&](size_t value) {
            const auto v = uint32_t(value);
            file.append(reinterpret_cast<const char*>(&v), 4);
        };
        word(0x46546C67), word(2), word(total);
        word(json.size()), word(0x4E4F534A), file += json;
        if (!buffer_.empty()) word(buffer_.size()), word(0x004E4942), file += buffer_;
        return file;
    }

    const Scene& scene_;
    Json root_;
    std::string buffer_;
    bool hasHighlights_ = false;
    std::vector<int> meshOf_;  // glTF mesh of a prototype; -1: it has no triangle
};

}  // namespace

void writeGlb(const Scene& scene, const std::filesystem::path& path) { base::writeFile(path, GlbWriter(scene).write()); }

}  // namespace dapple::scenegen
