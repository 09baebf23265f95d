#include "scenegen/import/own_glb.h"

#include "base/error.h"
#include "base/file.h"
#include "scenegen/export/glb.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cstring>
#include <fstream>
#include <stdexcept>

// Khronos, "glTF 2.0 Specification" (2021), sections 3.6 and 4.4.
namespace dapple::scenegen {
namespace {
using Json = nlohmann::json;

template <class Vec>
Vec vec(const Json& j) {
    Vec v;
    for (int i = 0; i < Vec::length(); ++i) v[i] = j.at(size_t(i)).get<typename Vec::value_type>();
    return v;
}

/// y up to z up, exactly.
glm::vec3 zUp(const glm::vec3& v) { return {v.x, -v.z, v.y}; }

class Reader {
public:
    Reader(const Json& root, std::string_view buffer) : root_(root), buffer_(buffer) {}

    Scene read() const {
        const Json& gltfScene = root_.at("scenes").at(0);
        const Json& exact = gltfScene.at("extras");
        Scene scene;
        scene.name = gltfScene.at("name").get<std::string>();
        scene.origin = vec<glm::dvec3>(exact.at("origin"));
        scene.sun = {exact.at("sun").at(0).get<double>(), exact.at("sun").at(1).get<double>()};
        for (const Json& s : exact.value("furtherSuns", Json::array())) scene.furtherSuns.push_back({s.at(0).get<double>(), s.at(1).get<double>(), s.at(2).get<double>()});
        readMaterials(scene, exact.at("materials"));
        for (const Json& p : exact.at("prototypes")) {
            Prototype& prototype = scene.prototypes.emplace_back();
            prototype.name = p.at("name").get<std::string>();
            prototype.castsShadow = p.at("castsShadow").get<bool>();
            prototype.closed = p.at("closed").get<bool>();
            prototype.moving = p.at("moving").get<bool>();
            prototype.transmittance = p.value("transmittance", 0.0f);
            const int mesh = p.at("mesh").get<int>();
            if (mesh < 0) continue;
            for (const Json& primitive : root_.at("meshes").at(size_t(mesh)).at("primitives")) prototype.meshes.push_back(readMesh(primitive));
        }
        for (size_t i = 0; i < exact.at("instances").size(); ++i) {
            const Json &node = root_.at("nodes").at(i), &known = exact.at("instances").at(i);
            scene.instances.push_back({zUp(vec<glm::vec3>(node.at("translation"))), node.at("scale").at(0).get<float>(), known.at(1).get<float>(), known.at(0).get<uint32_t>()});
        }
        for (const Json& v : exact.at("views"))
            scene.views.push_back({v.at("name").get<std::string>(), vec<glm::dvec3>(v.at("eye")), vec<glm::dvec3>(v.at("forward")), vec<glm::dvec3>(v.at("up")),
                                   v.at("fovY").get<double>(), v.at("near").get<double>(), v.at("far").get<double>()});
        for (const Json& l : exact.at("lights"))
            scene.lights.push_back({vec<glm::vec3>(l.at("position")), vec<glm::vec3>(l.at("direction")), vec<glm::vec3>(l.at("intensity")),
                                    l.at("range").get<float>(), l.at("innerAngle").get<float>(), l.at("outerAngle").get<float>()});
        for (const Json& m : exact.at("motions"))
            scene.motions.push_back({m.at("instance").get<uint32_t>(), vec<glm::vec3>(m.at("from")), vec<glm::vec3>(m.at("to")), m.at("speed").get<float>(), m.at("start").get<float>(),
                                     m.at("across").get<float>(), m.at("radius").get<float>()});
        return scene;
    }

private:
    std::string_view bytes(size_t view) const {
        const Json& j = root_.at("bufferViews").at(view);
        const auto offset = j.at("byteOffset").get<size_t>(), length = j.at("byteLength").get<size_t>();
        if (offset > buffer_.size() || length > buffer_.size() - offset) throw std::out_of_range("a buffer view ends beyond the file");
        return buffer_.substr(offset, length);
    }

    template <class T>
    std::vector<T> accessor(const Json& index) const {
        const Json& j = root_.at("accessors").at(index.get<size_t>());
        const std::string_view data = bytes(j.at("bufferView").get<size_t>());
        std::vector<T> values(j.at("count").get<size_t>());
        if (data.size() != values.size() * sizeof(T)) throw std::out_of_range("an accessor is not as long as its buffer view");
        std::memcpy(values.data(), data.data(), data.size());
        return values;
    }

    void readMaterials(Scene& scene, const Json& exact) const {
        for (const Json& texture : root_.value("textures", Json::array())) {
            const Json& image = root_.at("images").at(texture.at("source").get<size_t>());
            const std::string_view png = bytes(image.at("bufferView").get<size_t>());
            const auto name = image.at("name").get<std::string>();
            scene.textures.push_back({name, base::decodeImage({reinterpret_cast<const uint8_t*>(png.data()), png.size()}, name)});
        }
        for (size_t i = 0; i < exact.size(); ++i) {
            const Json &j = root_.at("materials").at(i), &surface = j.at("pbrMetallicRoughness");
            Material& m = scene.materials.emplace_back();
            m.name = j.at("name").get<std::string>();
            m.albedo = vec<glm::vec3>(surface.at("baseColorFactor"));
            m.specular = exact.at(i).at(0).get<float>();
            m.shininess = exact.at(i).at(1).get<float>();
            if (surface.contains("baseColorTexture")) m.texture = surface.at("baseColorTexture").at("index").get<int>();
            m.alphaTested = j.value("alphaMode", "OPAQUE") == "MASK";
            m.doubleSided = j.at("doubleSided").get<bool>();
        }
    }

    Mesh readMesh(const Json& primitive) const {
        Mesh mesh;
        const Json& attributes = primitive.at("attributes");
        mesh.positions = accessor<glm::vec3>(attributes.at("POSITION"));
        mesh.normals = accessor<glm::vec3>(attributes.at("NORMAL"));
        for (auto* values : {&mesh.positions, &mesh.normals})
            for (glm::vec3& v : *values) v = zUp(v);
        if (attributes.contains("TEXCOORD_0")) mesh.uvs = accessor<glm::vec2>(attributes.at("TEXCOORD_0"));
        mesh.indices = accessor<uint32_t>(primitive.at("indices"));
        mesh.material = primitive.at("material").get<uint32_t>();
        return mesh;
    }

    const Json& root_;
    std::string_view buffer_;
};

}  // namespace

std::optional<Scene> readOwnGlb(const std::filesystem::path& path) {
    if (path.extension() != ".glb" || !std::filesystem::is_regular_file(path)) return {};
    uint32_t header[5] = {};  // magic, version, length; length and type of the JSON chunk
    const auto size = std::filesystem::file_size(path);
    std::ifstream stream(path, std::ios::binary);
    if (size < sizeof header || !stream.read(reinterpret_cast<char*>(header), sizeof header)) return {};
    if (header[0] != 0x46546C67 || header[3] > size - sizeof header) return {};
    // Of others' files no more is read than says that they are: the importer reads them again.
    std::string json(header[3], '\0');
    if (!stream.read(json.data(), std::streamsize(json.size()))) return {};
    const Json root = Json::parse(json, nullptr, false);
    if (!root.is_object() || !root.contains("asset") || root["asset"].value("generator", "") != kGlbGenerator) return {};
    const std::string file = base::readFile(path);
    try {
        const size_t binary = sizeof header + header[3];
        uint32_t chunk[2] = {};
        if (file.size() >= binary + sizeof chunk) std::memcpy(chunk, file.data() + binary, sizeof chunk);
        if (header[2] != file.size()) throw std::out_of_range("its length is not what its header says");
        Scene scene = Reader(root, chunk[0] > 0 ? std::string_view(file).substr(binary + sizeof chunk, chunk[0]) : std::string_view()).read();
        scene.source = path.string();
        return scene;
    } catch (const std::exception& error) {  // of the JSON library, of the images, and ours
        throw base::UsageError(fmt::format("{}: a damaged file of dapple's: {}", path.string(), error.what()));
    }
}

}  // namespace dapple::scenegen
