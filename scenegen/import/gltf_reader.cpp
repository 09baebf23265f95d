#include "scenegen/import/gltf_reader.h"

#include "scenegen/import/gltf_accessors.h"
#include "scenegen/import/gltf_materials.h"
#include "scenegen/import/gltf_meshes.h"
#include "scenegen/import/scene_builder.h"

#include <fmt/format.h>
#include <glm/gtc/quaternion.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <set>

// Khronos, "glTF 2.0 Specification" (2021), sections 3.5, 3.7.3 and 3.10.
namespace dapple::scenegen {
namespace {

glm::dmat4 matrixOf(const glm::dvec3& translation, const glm::dvec4& rotation, const glm::dvec3& scale) {
    glm::dquat q(rotation.w, rotation.x, rotation.y, rotation.z);
    const double length = glm::length(q);
    q = length > 0 ? q / length : glm::dquat(1, 0, 0, 0);
    return glm::translate(glm::dmat4(1), translation) * glm::mat4_cast(q) * glm::scale(glm::dmat4(1), scale);
}

glm::dmat4 parentFromNode(const Json& node) {
    if (node.contains("matrix")) {
        glm::dmat4 m;
        for (size_t i = 0; i < 16; ++i) m[int(i / 4)][int(i % 4)] = node.at("matrix").at(i).get<double>();
        return m;
    }
    return matrixOf(vectorOf(member(node, "translation"), glm::dvec3(0)), vectorOf(member(node, "rotation"), glm::dvec4(0, 0, 0, 1)),
                    vectorOf(member(node, "scale"), glm::dvec3(1)));
}

/// Degrees to the digits that a float holds: other programs turn angles into radians and floats, and 60° comes back as 60.0000017°.
double digits(double degrees) { return std::round(degrees * 1e5) / 1e5; }

/// A length as it was written before a program made it a float.
double asWritten(double length) {
    const auto rounded = float(length);
    return std::abs(length - double(rounded)) < 1e-8 * length ? std::stod(fmt::format("{}", rounded)) : length;
}

/// Meshes that stand in the same two or more places are parts of one thing: some programs draw a tree's bark and leaves as
/// two forests.
void joinParts(FileScene& scene) {
    using Places = std::vector<std::array<double, 16>>;
    std::map<std::pair<bool, std::vector<uint32_t>>, std::vector<size_t>> objectsOf;
    for (size_t i = 0; i < scene.objects.size(); ++i) objectsOf[{scene.objects[i].castsShadow, scene.objects[i].meshes}].push_back(i);
    std::map<std::pair<bool, Places>, const std::vector<size_t>*> firstAt;
    std::vector<bool> gone(scene.objects.size(), false);
    for (const auto& [shape, objects] : objectsOf) {
        if (objects.size() < 2) continue;
        Places places(objects.size());
        for (size_t k = 0; k < objects.size(); ++k) std::copy_n(glm::value_ptr(scene.objects[objects[k]].worldFromObject), 16, places[k].begin());
        const auto [it, isFirst] = firstAt.try_emplace({shape.first, std::move(places)}, &objects);
        if (isFirst) continue;
        for (size_t k = 0; k < objects.size(); ++k) {
            std::vector<uint32_t>& meshes = scene.objects[(*it->second)[k]].meshes;
            meshes.insert(meshes.end(), shape.second.begin(), shape.second.end());
            gone[objects[k]] = true;
        }
    }
    size_t next = 0;
    std::erase_if(scene.objects, [&](const FileScene::Object&) { return gone[next++]; });
}

class Reader {
public:
    Reader(GltfDocument& document, const Sidecar& sidecar)
        : document_(document), builder_(document.file(), sidecar, 'y'), unit_(builder_.metresPerUnit()), textures_(document, sidecar.textures), materials_(document, textures_, builder_), meshes_(document, materials_, builder_) {}

    FileScene read() {
        for (size_t s = 0; s < document_.count("skins"); ++s)
            for (const size_t joint : document_.indices(document_.item("skins", s), "joints")) joints_[joint];
        readNodes();
        for (const auto& [node, json] : skinned_) addSkinned(node, *json);
        if (document_.count("animations") > 0)
            document_.notes.add("animations are ignored: all stands as its nodes say", valueOf<std::string>(document_.item("animations", 0), "name", ""), document_.count("animations"));
        if (document_.count("scenes") > 1) document_.notes.add("scenes beside the default one are left out", "", document_.count("scenes") - 1);
        builder_.scene.notes.add(document_.notes);
        FileScene scene = builder_.finish();
        scene.textures = std::move(textures_.textures);
        joinParts(scene);
        return scene;
    }

private:
    using Node = SceneBuilder::Node;

    /// Those of the default scene, else of the first; without scenes, the nodes that have no parent.
    std::vector<size_t> roots() const {
        std::vector<size_t> result;
        if (document_.count("scenes") > 0) return document_.indices(document_.item("scenes", document_.indexOr(document_.root(), "scene", 0)), "nodes");
        std::set<size_t> children;
        for (size_t i = 0; i < document_.count("nodes"); ++i)
            for (const size_t child : document_.indices(document_.item("nodes", i), "children")) children.insert(child);
        for (size_t i = 0; i < document_.count("nodes"); ++i)
            if (!children.contains(i)) result.push_back(i);
        return result;
    }

    /// Refuses circles, and more nodes than a file may have, each path to one counted: nodes that several parents share multiply.
    /// Linear in the nodes, and without recursion: files nest them as deep as they like.
    void checkGraph(const std::vector<size_t>& roots) {
        enum class State : uint8_t { unseen, open, done };
        std::vector<State> states(document_.count("nodes"), State::unseen);
        std::vector<double> paths(states.size(), 1);  // through the node and all below it
        std::vector<size_t> stack(roots);
        while (!stack.empty()) {
            const size_t node = stack.back();
            const std::vector<size_t> children = document_.indices(document_.item("nodes", node), "children");
            if (states[node] == State::unseen) {
                states[node] = State::open;
                for (const size_t child : children) {
                    const Json& json = document_.item("nodes", child);
                    if (states[child] == State::open) document_.fail(fmt::format("is damaged: node '{}' is its own ancestor", nameOf(child, json)));
                    if (states[child] == State::unseen) stack.push_back(child);
                }
                continue;
            }
            stack.pop_back();
            if (states[node] == State::done) continue;
            states[node] = State::done;
            for (const size_t child : children) paths[node] += paths[child];
        }
        double sum = 0;
        for (const size_t root : roots) sum += paths[root];
        document_.budget.nodes(size_t(std::min(sum, 1e15)));
    }

    /// Depth first, in the file's order.
    void readNodes() {
        struct Step {
            size_t node;
            std::shared_ptr<const Node> parent;
        };
        std::vector<Step> steps;
        const auto push = [&](const std::vector<size_t>& nodes, const std::shared_ptr<const Node>& parent) {
            for (auto it = nodes.rbegin(); it != nodes.rend(); ++it) steps.push_back({*it, parent});
        };
        const std::vector<size_t> first = roots();
        checkGraph(first);
        push(first, std::make_shared<Node>());
        for (size_t visited = 0; !steps.empty(); ++visited) {
            if (visited % 4096 == 0) document_.budget.time();
            const Step step = std::move(steps.back());
            steps.pop_back();
            const Json& json = document_.item("nodes", step.node);
            const auto here = std::make_shared<const Node>(readNode(step.node, json, *step.parent));
            push(document_.indices(json, "children"), here);
        }
    }

    /// A node without a name has its mesh's, or its camera's.
    std::string nameOf(size_t index, const Json& node) const {
        std::string name = valueOf<std::string>(node, "name", "");
        if (name.empty() && node.contains("mesh")) name = valueOf<std::string>(document_.item("meshes", document_.index(node, "mesh")), "name", "");
        if (name.empty() && node.contains("camera")) name = valueOf<std::string>(document_.item("cameras", document_.index(node, "camera")), "name", "");
        return name.empty() ? fmt::format("node {}", index) : name;
    }

    Node readNode(size_t index, const Json& json, const Node& parent) {
        const std::string name = nameOf(index, json);
        Node node = builder_.child(parent, name, parentFromNode(json));
        if (!base::allFinite(glm::mat4(node.worldFromNode))) document_.fail(fmt::format("node '{}' has a transform that is not finite", name));
        if (const auto joint = joints_.find(index); joint != joints_.end()) joint->second = node.worldFromNode;
        if (json.contains("mesh") && json.contains("skin")) skinned_.emplace_back(node, &json);
        else if (json.contains("mesh")) addMesh(node, json);
        if (json.contains("camera")) addCamera(node, document_.item("cameras", document_.index(json, "camera")));
        if (const Json& light = extension(json, "KHR_lights_punctual"); !light.is_null()) addLight(node, document_.index(light, "light"));
        return node;
    }

    /// writeGlb() marks what only receives shadows; other programs hand the mark on.
    bool casts(const Node& node, size_t mesh) const {
        const Json& marks = member(document_.item("meshes", mesh), "extras");
        return node.castsShadow && !(marks.is_object() && member(marks, "castsShadow") == Json(false));
    }

    void addMesh(Node node, const Json& json) {
        const size_t mesh = document_.index(json, "mesh");
        const std::vector<uint32_t>& meshes = meshes_.of(mesh, meshes_.weightsOf(json, mesh));
        if (meshes.empty()) return;
        node.castsShadow = casts(node, mesh);
        const Json& instancing = extension(json, "EXT_mesh_gpu_instancing");
        if (instancing.is_null()) {
            document_.budget.instances(1);
            builder_.addObject(node, meshes);
            return;
        }
        const glm::dmat4 world = node.worldFromNode;
        for (const glm::dmat4& nodeFromInstance : instancesOf(member(instancing, "attributes"))) {
            node.worldFromNode = world * nodeFromInstance;
            if (!base::allFinite(glm::mat4(node.worldFromNode))) document_.fail(fmt::format("an instance of node '{}' has a transform that is not finite", node.name));
            builder_.addObject(node, meshes);
        }
    }

    std::vector<glm::dmat4> instancesOf(const Json& attributes) {
        std::optional<size_t> count;
        for (const char* name : {"TRANSLATION", "ROTATION", "SCALE"}) {
            if (!attributes.contains(name)) continue;
            const size_t own = document_.index(document_.item("accessors", document_.index(attributes, name)), "count");
            if (count.value_or(own) != own) document_.fail("is damaged: attributes of EXT_mesh_gpu_instancing differ in count");
            count = own;
        }
        if (!count) document_.fail("is damaged: EXT_mesh_gpu_instancing has neither TRANSLATION nor ROTATION nor SCALE");
        document_.budget.instances(*count);
        const auto read = [&]<class Vec>(const char* name, const Vec& otherwise) {
            if (!attributes.contains(name)) return std::vector<Vec>(*count, otherwise);
            return asVectors<Vec>(readFloats(document_, document_.index(attributes, name), size_t(Vec::length())));
        };
        const auto translations = read("TRANSLATION", glm::vec3(0)), scales = read("SCALE", glm::vec3(1));
        const auto rotations = read("ROTATION", glm::vec4(0, 0, 0, 1));
        std::vector<glm::dmat4> result;
        for (size_t i = 0; i < *count; ++i) result.push_back(matrixOf(translations[i], rotations[i], scales[i]));
        return result;
    }

    /// A skinned mesh stands where its joints are; its own node's transform does not count (section 3.7.3.3).
    void addSkinned(Node node, const Json& json) {
        const Json& skin = document_.item("skins", document_.index(json, "skin"));
        const std::vector<size_t> joints = document_.indices(skin, "joints");
        std::vector<glm::mat4> inverseBinds(joints.size(), glm::mat4(1));
        if (skin.contains("inverseBindMatrices")) {
            const std::vector<float> values = readFloats(document_, document_.index(skin, "inverseBindMatrices"), 16);
            if (values.size() < 16 * joints.size()) document_.fail(fmt::format("is damaged: the skin of node '{}' has {} inverse bind matrices for {} joints", node.name, values.size() / 16, joints.size()));
            for (size_t i = 0; i < joints.size(); ++i) inverseBinds[i] = glm::make_mat4(&values[16 * i]);
        }
        GltfPose pose;
        for (size_t i = 0; i < joints.size(); ++i) {
            const std::optional<glm::dmat4>& world = joints_.at(joints[i]);
            if (!world) document_.fail(fmt::format("the skin of node '{}' has a joint, nodes[{}], that is not part of the scene", node.name, joints[i]));
            pose.worldFromBind.push_back(*world * glm::dmat4(inverseBinds[i]));
        }
        const size_t mesh = document_.index(json, "mesh");
        std::vector<uint32_t> meshes = meshes_.skinned(mesh, meshes_.weightsOf(json, mesh), pose);
        node.castsShadow = casts(node, mesh);
        node.worldFromNode = glm::dmat4(1);
        if (!meshes.empty()) builder_.addObject(node, std::move(meshes));
    }

    void addCamera(const Node& node, const Json& camera) {
        if (valueOf<std::string>(camera, "type", "") != "perspective") {
            document_.notes.add("cameras that are not perspective are left out", node.name);
            return;
        }
        const Json& perspective = member(camera, "perspective");
        View lens;
        lens.fovY = digits(glm::degrees(valueOf(perspective, "yfov", 0.0)));
        lens.near = asWritten(valueOf(perspective, "znear", 0.0));
        lens.far = asWritten(valueOf(perspective, "zfar", 0.0));
        builder_.addView(node, node.name, glm::dvec3(0), {0, 0, -1}, {0, 1, 0}, lens);
    }

    void addLight(const Node& node, size_t index) {
        const Json& lights = member(extension(document_.root(), "KHR_lights_punctual"), "lights");
        if (index >= lights.size()) document_.fail(fmt::format("is damaged: asks for light {}, which does not exist", index));
        const Json& light = lights.at(index);
        const std::string type = valueOf<std::string>(light, "type", "");
        const double intensity = valueOf(light, "intensity", 1.0);
        if (type == "directional") addSun(node, intensity);
        else if (type == "point" || type == "spot") addLamp(node, light, intensity);
        else document_.fail(fmt::format("is damaged: a light has the type '{}', which does not exist", type));
    }

    void addSun(const Node& node, double intensity) {
        std::optional<Sun> sun = builder_.sunOf(node, {0, 0, -1});
        FileScene& scene = builder_.scene;
        if (!sun) return document_.notes.add("directional lights that do not shine downwards are left out", node.name);
        sun->azimuth = digits(sun->azimuth);
        sun->elevation = digits(sun->elevation);
        if (!scene.sun) {
            scene.sun = sun;
            sunIntensity_ = intensity;
            return;
        }
        sun->strength = sunIntensity_ > 0 ? intensity / sunIntensity_ : 0;
        if (!(sun->strength > 0 && sun->strength <= 100)) return document_.notes.add("suns without light are left out", node.name);
        if (scene.furtherSuns.size() + 2 > kMostSuns) return document_.notes.add(fmt::format("suns beyond the first {} are left out", kMostSuns), node.name);
        scene.furtherSuns.push_back(*sun);
    }

    /// KHR_lights_punctual. Where no range is named, the lamp reaches to where it adds less than a hundredth.
    void addLamp(const Node& node, const Json& json, double intensity) {
        FileScene::Lamp lamp;
        LocalLight& light = lamp.light;
        light.intensity = glm::vec3(unit_ * unit_ * intensity * vectorOf(member(json, "color"), glm::dvec3(1)));
        const float strongest = std::max({light.intensity.x, light.intensity.y, light.intensity.z});
        if (!(strongest > 0) || !std::isfinite(strongest)) return document_.notes.add("lamps without light are left out", node.name);
        light.range = json.contains("range") ? float(unit_ * json["range"].get<double>()) : std::sqrt(100 * strongest);
        const glm::dvec3 direction = builder_.direction(glm::dmat3(node.worldFromNode) * glm::dvec3(0, 0, -1));
        if (glm::length(direction) > 1e-9) light.direction = glm::vec3(glm::normalize(direction));
        lamp.position = builder_.position(glm::dvec3(node.worldFromNode[3]));
        if (valueOf<std::string>(json, "type", "") == "spot") {
            const Json& spot = member(json, "spot");
            light.innerAngle = float(valueOf(spot, "innerConeAngle", 0.0));
            light.outerAngle = float(valueOf(spot, "outerConeAngle", glm::radians(45.0)));
            if (!(light.innerAngle >= 0 && light.innerAngle < light.outerAngle && light.outerAngle <= 1.5709f)) return document_.notes.add("spots whose angles make no cone are left out", node.name);
        }
        if (!(light.range > 0 && std::isfinite(light.range))) return document_.notes.add("lamps without range are left out", node.name);
        builder_.scene.lamps.push_back(lamp);
    }

    GltfDocument& document_;
    SceneBuilder builder_;
    double unit_;
    GltfTextures textures_;
    GltfMaterials materials_;
    GltfMeshes meshes_;
    std::map<size_t, std::optional<glm::dmat4>> joints_;  ///< world transforms of the nodes that are joints
    std::vector<std::pair<Node, const Json*>> skinned_;
    double sunIntensity_ = 1;
};

}  // namespace

bool isGltf(const std::filesystem::path& file) {
    const std::string extension = lowerExtension(file);
    return extension == ".gltf" || extension == ".glb";
}

FileScene readGltf(GltfDocument& document, const Sidecar& sidecar) {
    try {
        FileScene scene = Reader(document, sidecar).read();
        if (scene.meshes.empty()) document.fail("has no triangle");
        return scene;
    } catch (const Json::exception& error) {  // a value of another type than the specification's
        document.fail("is damaged: " + reasonOf(error));
    }
}

}  // namespace dapple::scenegen
