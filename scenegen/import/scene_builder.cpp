#include "scenegen/import/scene_builder.h"

#include "base/error.h"
#include "base/hash.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace dapple::scenegen {
namespace {

bool same(const Mesh& a, const Mesh& b) {
    return a.positions == b.positions && a.indices == b.indices && a.normals == b.normals && a.uvs == b.uvs && a.material == b.material;
}

}  // namespace

FileSpace::FileSpace(const std::string& up) {
    const char axis = up.back();
    if (axis == 'x') axes = {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}};
    if (axis == 'y') axes = {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}};
    if (up.front() == '-') axes = glm::dmat3({1, 0, 0}, {0, -1, 0}, {0, 0, -1}) * axes;  // half a turn about x
}

SceneBuilder::SceneBuilder(const std::filesystem::path& file, const Sidecar& sidecar, const FileSpace& space)
    : file_(file), sidecar_(sidecar), space_(space), copyFound_(sidecar.copies.size(), false) {
    if (sidecar.up) space_.axes = FileSpace(*sidecar.up).axes;
    if (sidecar.unit) space_.metresPerUnit = *sidecar.unit;
}

void SceneBuilder::fail(const std::string& why) const { throw base::UsageError(file_.string() + ": " + why); }

uint32_t SceneBuilder::addMaterial(const Material& material) {
    const Material& m = material;
    const MaterialKey key{m.albedo.x, m.albedo.y, m.albedo.z, m.specular, m.shininess, m.texture, m.alphaTested, m.alphaCutoff};
    const auto [it, isNew] = materials_.emplace(key, uint32_t(scene.materials.size()));
    if (isNew) scene.materials.push_back(material);
    return it->second;
}

uint32_t SceneBuilder::addMesh(Mesh mesh) {
    if (glm::determinant(space_.axes) < 0)
        for (size_t i = 0; i < mesh.indices.size(); i += 3) std::swap(mesh.indices[i + 1], mesh.indices[i + 2]);
    base::Hasher h;
    h.array(std::span<const glm::vec3>(mesh.positions));
    h.array(std::span<const uint32_t>(mesh.indices));
    std::vector<uint32_t>& candidates = meshesByHash_[h.digest()];
    const auto it = std::ranges::find_if(candidates, [&](uint32_t i) { return same(scene.meshes[i], mesh); });
    if (it != candidates.end()) return *it;
    double farthest = 0;
    for (const glm::vec3& p : mesh.positions) farthest = std::max(farthest, double(glm::length(p)));
    farthest_.push_back(farthest);
    candidates.push_back(uint32_t(scene.meshes.size()));
    scene.meshes.push_back(std::move(mesh));
    return candidates.back();
}

SceneBuilder::Node SceneBuilder::child(const Node& parent, const std::string& name, const glm::dmat4& parentFromNode) {
    for (size_t i = 0; i < copyFound_.size(); ++i)
        if (sidecar_.copies[i].node == name) copyFound_[i] = true;
    return {name, parent.worldFromNode * parentFromNode, parent.castsShadow && !matchesAny(name, sidecar_.receivers)};
}

/// A transform between file spaces as one between ours: positions are turned and scaled on both sides.
glm::dmat4 SceneBuilder::conjugate(const glm::dmat4& m) const {
    glm::dmat4 r(space_.axes * glm::dmat3(m) * glm::transpose(space_.axes));
    r[3] = glm::dvec4(position(glm::dvec3(m[3])), 1);
    return r;
}

void SceneBuilder::noteCoarse(const std::string& name, double farthest) {
    constexpr double kFine = 1e-3;  // metres
    const double step = farthest * double(std::numeric_limits<float>::epsilon()) / 2;
    if (step > kFine)
        scene.notes.add("coordinates far from the origin are floats, in steps of more than a millimetre", fmt::format("{}: {:.2g} m", name, step));
}

void SceneBuilder::addObject(const Node& node, std::vector<uint32_t> meshes) {
    double farthest = 0;
    for (const uint32_t m : meshes) farthest = std::max(farthest, farthest_[m]);
    const glm::dmat3 linear(node.worldFromNode);
    noteCoarse(node.name, farthest * std::max({glm::length(linear[0]), glm::length(linear[1]), glm::length(linear[2])}));
    FileScene::Object object{node.name, conjugate(node.worldFromNode), std::move(meshes), node.castsShadow};
    for (const Sidecar::Copy& copy : sidecar_.copies) {
        if (copy.node != node.name) continue;
        scene.objects.push_back(object);
        glm::dmat4& m = scene.objects.back().worldFromObject;
        m = glm::rotate(glm::dmat4(1), glm::radians(copy.yaw), glm::dvec3(0, 0, 1)) * glm::dmat4(glm::dmat3(m));
        m[3] = glm::dvec4(copy.to, 1);
    }
    if (!matchesAny(node.name, sidecar_.drop)) scene.objects.push_back(std::move(object));
}

void SceneBuilder::addView(const Node& node, const std::string& name, const glm::dvec3& eye, const glm::dvec3& forward, const glm::dvec3& up, const View& lens) {
    View view;
    view.eye = position(glm::dvec3(node.worldFromNode * glm::dvec4(eye, 1)));
    view.forward = direction(glm::dmat3(node.worldFromNode) * forward);
    view.up = direction(glm::dmat3(node.worldFromNode) * up);
    if (!(glm::length(glm::cross(view.forward, view.up)) > 1e-9)) return;
    view.forward = glm::normalize(view.forward);
    view.up = glm::normalize(view.up);
    if (lens.fovY > 1 && lens.fovY < 170) view.fovY = lens.fovY;  // Assimp 5.2 loses the angle of COLLADA: 0.8°
    if (lens.near > 0 && std::isfinite(lens.near)) view.near = metresPerUnit() * lens.near;
    const double far = metresPerUnit() * lens.far;
    view.far = far > view.near && std::isfinite(far) ? far : 0;
    const auto taken = [&](const std::string& n) { return std::ranges::any_of(scene.views, [&](const View& v) { return v.name == n; }); };
    view.name = name;
    for (int number = 2; taken(view.name); ++number) view.name = fmt::format("{} {}", name, number);
    if (view.name != name) scene.notes.add("views of one name are numbered", name);
    scene.views.push_back(view);
}

std::optional<Sun> SceneBuilder::sunOf(const Node& node, const glm::dvec3& lightDirection) const {
    const glm::dvec3 toSun = -direction(glm::dmat3(node.worldFromNode) * lightDirection);
    if (!(toSun.z > 1e-3 * glm::length(toSun))) return {};
    const double azimuth = glm::degrees(std::atan2(toSun.x, toSun.y));
    return Sun{azimuth < 0 ? azimuth + 360 : azimuth, glm::degrees(std::asin(std::min(1.0, toSun.z / glm::length(toSun))))};
}

FileScene SceneBuilder::finish() {
    for (size_t i = 0; i < copyFound_.size(); ++i)
        if (!copyFound_[i]) fail(fmt::format("its .toml copies node '{}', which does not exist", sidecar_.copies[i].node));
    return std::move(scene);
}

}  // namespace dapple::scenegen
