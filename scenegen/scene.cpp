#include "scenegen/scene.h"

#include "base/detmath.h"
#include "base/error.h"
#include "base/hash.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace dapple::scenegen {
namespace {

void hashMesh(base::Hasher& h, const Mesh& mesh) {
    h.array(std::span<const glm::vec3>(mesh.positions));
    h.array(std::span<const glm::vec3>(mesh.normals));
    h.array(std::span<const glm::vec2>(mesh.uvs));
    h.array(std::span<const uint32_t>(mesh.indices));
    h.value(mesh.material);
}

void requireFinite(bool ok, const std::string& scene, const std::string& what) {
    if (!ok) throw base::UsageError(fmt::format("scene {}: {} is not finite (NaN or infinite)", scene, what));
}

void validateMesh(const Scene& scene, const Prototype& prototype, const Mesh& mesh) {
    const auto fail = [&](const char* why) {
        throw base::UsageError(fmt::format("scene {}: prototype '{}': {}", scene.name, prototype.name, why));
    };
    if (mesh.material >= scene.materials.size()) fail("a mesh names a material that does not exist");
    if (mesh.normals.size() != mesh.positions.size()) fail("a mesh has not one normal per position");
    if (!mesh.uvs.empty() && mesh.uvs.size() != mesh.positions.size()) fail("a mesh has not one texture coordinate per position");
    if (scene.materials[mesh.material].texture >= 0 && mesh.uvs.empty()) fail("a textured mesh has no texture coordinates");
    if (mesh.indices.size() % 3 != 0) fail("a mesh has a number of indices that is not a multiple of 3");
    for (const uint32_t i : mesh.indices)
        if (i >= mesh.positions.size()) fail("an index is beyond the last vertex");
    const auto finite = [](const auto& values) { return std::all_of(values.begin(), values.end(), [](const auto& v) { return base::allFinite(v); }); };
    requireFinite(finite(mesh.positions), scene.name, "a vertex of '" + prototype.name + "'");
    requireFinite(finite(mesh.normals), scene.name, "a normal of '" + prototype.name + "'");
    requireFinite(finite(mesh.uvs), scene.name, "a texture coordinate of '" + prototype.name + "'");
}

}  // namespace

size_t Prototype::triangles() const {
    size_t sum = 0;
    for (const Mesh& mesh : meshes) sum += mesh.triangles();
    return sum;
}

base::Box Prototype::box() const {
    base::Box box;
    for (const Mesh& mesh : meshes)
        for (const glm::vec3& p : mesh.positions) box.extend(p);
    return box;
}

glm::dvec3 Sun::direction() const {
    const double a = glm::radians(azimuth), e = glm::radians(elevation);
    // The zenith must be exact: cos(90°) is 6e-17, and techniques branch on "parallel to the vertical".
    const double c = elevation == 90.0 ? 0.0 : std::cos(e);
    return -glm::dvec3(std::sin(a) * c, std::cos(a) * c, std::sin(e));
}

base::Box instanceBox(const base::Box& prototypeBox, const Instance& instance) {
    base::Box box;
    if (prototypeBox.empty()) return box;
    const float c = std::cos(instance.yaw) * instance.scale, s = std::sin(instance.yaw) * instance.scale;
    for (int i = 0; i < 8; ++i) {
        const glm::vec3 p = prototypeBox.corner(i);
        box.extend(instance.translation + glm::vec3(c * p.x - s * p.y, s * p.x + c * p.y, instance.scale * p.z));
    }
    return box;
}

double Motion::swing() const {
    // Circles of the first and the second arc touch: their middles are across/2 + radius and 2 radius apart, across the way and in all.
    const double cosine = (0.5 * double(across) + double(radius)) / (2 * double(radius));
    return cosine < 1 ? base::det::acos(cosine) : 0;
}

double Motion::turn() const { return double(radius) * (base::det::kPi + 4 * swing()); }
double Motion::turnBeyond() const { return 2 * double(radius) * base::det::sin(swing()); }
double Motion::lap() const { return 2 * (glm::distance(glm::dvec2(from), glm::dvec2(to)) + turn()); }

Motion::Pose Motion::at(double seconds) const {
    const glm::dvec2 way(glm::dvec3(to) - glm::dvec3(from));
    const double length = glm::length(way), half = length + turn(), r = double(radius), side = swing();
    const glm::dvec2 ahead = way / length, left(-ahead.y, ahead.x);
    const double driven = double(start) + double(speed) * seconds;
    double s = driven - 2 * half * std::floor(driven / (2 * half));
    const bool back = s >= half;  // as the first half, turned about
    if (back) s -= half;
    glm::dvec2 p(std::min(s, length), 0);  // along the way there, and to its left
    double turned = 0;
    if (s > length) {
        const double in = s - length, toEnd = half - s;
        if (in < r * side) {
            turned = -in / r;
            const auto [sine, cosine] = base::det::sinCos(turned);
            p = {length - r * sine, -r * (1 - cosine)};
        } else if (toEnd > r * side) {
            turned = in / r - 2 * side;
            const auto [sine, cosine] = base::det::sinCos(turned);
            p = {length + turnBeyond() + r * sine, 0.5 * double(across) - r * cosine};
        } else {
            turned = base::det::kPi + toEnd / r;
            const auto [sine, cosine] = base::det::sinCos(toEnd / r);
            p = {length + r * sine, double(across) + r * (1 - cosine)};
        }
    }
    if (back) p = {length - p.x, double(across) - p.y}, turned += base::det::kPi;
    const double heading = base::det::acos(ahead.x), z = double(from.z) + (double(to.z) - double(from.z)) * std::clamp(p.x / length, 0.0, 1.0);
    return {glm::vec3(glm::dvec3(glm::dvec2(from) + p.x * ahead + p.y * left, z)), float((ahead.y < 0 ? -heading : heading) + turned)};
}

void Scene::moveTo(double seconds) {
    time = seconds;
    for (const Motion& m : motions) {
        const Motion::Pose pose = m.at(seconds);
        instances[m.instance].translation = pose.translation;
        instances[m.instance].yaw = pose.yaw;
    }
}

Facts Scene::facts() const {
    Facts f;
    f.suns = 1 + furtherSuns.size();
    f.lights = lights.size();
    f.moving = std::any_of(motions.begin(), motions.end(), [](const Motion& m) { return m.speed > 0; });
    f.prototypes = prototypes.size();
    f.materials = materials.size();
    f.instances = instances.size();
    f.closed = true;
    std::vector<base::Box> boxes;
    for (const Prototype& p : prototypes) {
        boxes.push_back(p.box());
        f.uniqueTriangles += p.triangles();
    }
    for (const Instance& instance : instances) {
        const Prototype& p = prototypes[instance.prototype];
        f.box.extend(instanceBox(boxes[instance.prototype], instance));
        f.triangles += p.triangles();
        f.scaled |= instance.scale != 1.0f;
        for (const Mesh& mesh : p.meshes) f.alphaTested |= materials[mesh.material].alphaTested && mesh.triangles() > 0;
        f.moving |= p.moving;
        if (p.castsShadow && p.triangles() > 0) {
            f.casters = true;
            f.closed &= p.closed;
            f.translucent |= p.transmittance > 0;
            f.rotated |= instance.yaw != 0.0f;
        }
    }
    f.closed &= f.casters;
    f.receivers = f.triangles > 0;
    for (const View& v : views) f.depthRange = std::max(f.depthRange, v.far / v.near);
    return f;
}

uint64_t Scene::contentHash() const {
    base::Hasher h;
    const auto add = [&](const auto&... values) { (h.value(values), ...); };
    add(origin);
    for (const Texture& t : textures) {
        add(t.image.width, t.image.height);
        h.array(std::span<const uint8_t>(t.image.texels));
        if (t.wrapU != Wrap::repeat || t.wrapV != Wrap::repeat) add(t.wrapU, t.wrapV);
    }
    for (const Material& m : materials) {
        add(m.albedo, m.specular, m.shininess, m.texture, m.alphaTested, m.doubleSided);
        if (m.alphaTested && m.alphaCutoff != kAlphaCutoff) add(m.alphaCutoff);
    }
    for (const Prototype& p : prototypes) {
        add(p.castsShadow, p.closed);
        if (p.transmittance > 0) add(p.transmittance);
        for (const Mesh& mesh : p.meshes) hashMesh(h, mesh);
    }
    h.array(std::span<const Instance>(instances));
    for (const View& v : views) add(v.eye, v.forward, v.up, v.fovY, v.near, v.far);
    add(sun.azimuth, sun.elevation);
    for (const Sun& further : furtherSuns) add(further.azimuth, further.elevation, further.strength);
    for (const LocalLight& l : lights) add(l.position, l.direction, l.intensity, l.range, l.innerAngle, l.outerAngle);
    for (const Motion& m : motions) add(m.instance, m.from, m.to, m.speed, m.start, m.across, m.radius);
    return h.digest();
}

size_t Scene::viewIndex(const std::string& viewName) const {
    std::vector<std::string> known;
    for (size_t i = 0; i < views.size(); ++i) {
        if (views[i].name == viewName) return i;
        known.push_back(views[i].name);
    }
    throw base::UsageError(fmt::format("scene {}: {}", name, base::unknownName("view", viewName, known)));
}

void keepInstances(Scene& scene, const std::function<bool(size_t)>& keep) {
    constexpr uint32_t kGone = ~0u;
    std::vector<uint32_t> now;  // index of what was instance i
    std::vector<Instance> kept;
    for (size_t i = 0; i < scene.instances.size(); ++i) {
        const bool stays = keep(i);
        now.push_back(stays ? uint32_t(kept.size()) : kGone);
        if (stays) kept.push_back(scene.instances[i]);
    }
    if (kept.size() == scene.instances.size()) return;
    scene.instances = std::move(kept);
    std::erase_if(scene.motions, [&](const Motion& m) { return m.instance < now.size() && now[m.instance] == kGone; });
    for (Motion& m : scene.motions)
        if (m.instance < now.size()) m.instance = now[m.instance];
}

void dropBadInstances(Scene& scene) {
    constexpr float kFarthest = 1e9f;
    std::vector<base::Box> boxes;
    for (const Prototype& prototype : scene.prototypes) boxes.push_back(prototype.box());
    const auto reasonOf = [&](const Instance& i) -> std::string {
        if (!base::allFinite(i.translation) || !std::isfinite(i.scale) || !std::isfinite(i.yaw)) return "its transform is not finite";
        if (i.scale <= 0) return fmt::format("its scale is {}, not above 0", i.scale);
        if (i.prototype >= boxes.size() || boxes[i.prototype].empty()) return {};  // validate() has a say; or there is nothing
        const base::Box box = instanceBox(boxes[i.prototype], i);
        // NaN is not less, either. Squares and cubes of such lengths are still floats.
        const auto reaches = [](const glm::vec3& p) { return glm::all(glm::lessThan(glm::abs(p), glm::vec3(kFarthest))); };
        return reaches(box.lo) && reaches(box.hi) ? "" : fmt::format("its box reaches beyond {:g} m", kFarthest);
    };
    keepInstances(scene, [&](size_t i) {
        const Instance& instance = scene.instances[i];
        const std::string reason = reasonOf(instance);
        if (!reason.empty())
            scene.dropped.push_back(fmt::format("instance {} of '{}' dropped: {}", i, instance.prototype < scene.prototypes.size() ? scene.prototypes[instance.prototype].name : "?", reason));
        return reason.empty();
    });
}

void validate(const Scene& scene) {
    const auto fail = [&](const std::string& why) { throw base::UsageError(fmt::format("scene {}: {}", scene.name, why)); };
    requireFinite(base::allFinite(scene.origin), scene.name, "the origin");
    requireFinite(std::isfinite(scene.sun.azimuth) && std::isfinite(scene.sun.elevation), scene.name, "the sun");
    if (scene.furtherSuns.size() >= kMostSuns) fail(fmt::format("{} suns; at most {} can be told apart", scene.furtherSuns.size() + 1, kMostSuns));
    for (const Sun& further : scene.furtherSuns) {
        requireFinite(std::isfinite(further.azimuth) && std::isfinite(further.elevation), scene.name, "a further sun");
        if (!(further.strength > 0 && further.strength <= 100)) fail(fmt::format("a further sun has strength {}; it must lie in 0 < strength ≤ 100", further.strength));
    }
    for (const Material& m : scene.materials) {
        requireFinite(base::allFinite(m.albedo) && std::isfinite(m.specular) && std::isfinite(m.shininess), scene.name,
                      "material '" + m.name + "'");
        if (m.texture >= int(scene.textures.size())) fail("material '" + m.name + "' names a texture that does not exist");
        if (!(m.alphaCutoff > 0 && m.alphaCutoff <= 1)) fail(fmt::format("material '{}' has the alpha cut-off {}; it must lie in 0 < a ≤ 1", m.name, m.alphaCutoff));
        if (m.alphaTested && m.texture < 0) fail("material '" + m.name + "' is alpha-tested but has no texture");
    }
    for (const Prototype& p : scene.prototypes) {
        if (!(p.transmittance >= 0 && p.transmittance < 1))
            fail(fmt::format("prototype '{}' has transmittance {}; it must lie in 0 ≤ t < 1 (castsShadow = false lets all light through)", p.name, p.transmittance));
        for (const Mesh& mesh : p.meshes) validateMesh(scene, p, mesh);
    }
    for (size_t i = 0; i < scene.instances.size(); ++i) {
        const Instance& instance = scene.instances[i];
        if (instance.prototype >= scene.prototypes.size()) fail(fmt::format("instance {} names a prototype that does not exist", i));
        requireFinite(base::allFinite(instance.translation) && std::isfinite(instance.scale) && std::isfinite(instance.yaw),
                      scene.name, fmt::format("the transform of instance {}", i));
        if (instance.scale <= 0) fail(fmt::format("instance {} has scale {}; it must be above 0", i, instance.scale));
    }
    for (size_t i = 0; i < scene.lights.size(); ++i) {
        const LocalLight& light = scene.lights[i];
        requireFinite(base::allFinite(light.position) && base::allFinite(light.direction) && base::allFinite(light.intensity), scene.name,
                      fmt::format("local light {}", i));
        if (std::abs(glm::length(light.direction) - 1) > 1e-3f) fail(fmt::format("local light {} has a direction that is not of unit length", i));
        if (!(light.range > 0 && std::isfinite(light.range))) fail(fmt::format("local light {} has range {}; it must be above 0", i, light.range));
        if (!(light.innerAngle >= 0 && light.innerAngle < light.outerAngle && light.outerAngle <= 3.1416f))
            fail(fmt::format("local light {} has the angles {} and {}; they must satisfy 0 ≤ inner < outer ≤ π", i, light.innerAngle, light.outerAngle));
    }
    for (size_t i = 0; i < scene.motions.size(); ++i) {
        const Motion& m = scene.motions[i];
        if (m.instance >= scene.instances.size()) fail(fmt::format("motion {} names an instance that does not exist", i));
        requireFinite(base::allFinite(m.from) && base::allFinite(m.to) && std::isfinite(m.speed) && std::isfinite(m.start) && std::isfinite(m.across) && std::isfinite(m.radius),
                      scene.name, fmt::format("motion {}", i));
        if (glm::vec2(m.from) == glm::vec2(m.to) || m.speed < 0) fail(fmt::format("motion {} goes nowhere, or backwards", i));
        if (!(m.across > 0 && m.radius >= 0.5f * m.across)) fail(fmt::format("motion {} turns by {} m with a radius of {} m; it must be at least half of that, and both above 0", i, m.across, m.radius));
    }
    if (scene.views.empty()) fail("it has no view");
    for (const View& v : scene.views) {
        const bool finite = base::allFinite(v.eye) && base::allFinite(v.forward) && base::allFinite(v.up);
        requireFinite(finite && std::isfinite(v.fovY) && std::isfinite(v.near) && std::isfinite(v.far), scene.name,
                      "view '" + v.name + "'");
        if (!(v.near > 0 && v.far > v.near)) fail(fmt::format("view '{}': near {} and far {} must satisfy 0 < near < far", v.name, v.near, v.far));
        if (!(v.fovY > 0 && v.fovY < 180)) fail(fmt::format("view '{}': fovY {} must lie between 0 and 180 degrees", v.name, v.fovY));
        if (glm::length(glm::cross(v.forward, v.up)) < 1e-9) fail("view '" + v.name + "': forward and up are parallel");
    }
}

}  // namespace dapple::scenegen
