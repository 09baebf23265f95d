#include "shadow/instanced/caster_list.h"

#include "shadow/map/caster_cull.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dapple::shadow {
namespace {

struct GpuCasterType {
    glm::vec4 centre, half;  ///< of the box; half.w: κ²
    glm::vec2 depth;         ///< nearest, 1 / range
    float pad;               ///< metres by which the box is larger than the object's
    uint32_t unused;
};
static_assert(sizeof(GpuCasterType) == 48);

struct GpuCasterMap {
    glm::vec4 window;  ///< centre, 1 / half size
    glm::vec4 square;  ///< x, y, page, side in the atlas
};
static_assert(sizeof(GpuCasterMap) == 32);

}  // namespace

void CasterList::uploadTypes() {
    std::vector<GpuCasterType> types;
    for (const CasterType& type : maps_.types()) {
        const glm::vec3 half = type.box.halfSize();
        const glm::vec2 reach = glm::max(glm::abs(glm::vec2(type.box.lo)), glm::abs(glm::vec2(type.box.hi)));
        const float kappa = std::max(reach.x, reach.y) / std::max(half.z, 1e-6f);
        types.push_back({glm::vec4(type.box.centre(), 0), glm::vec4(half, kappa * kappa), {type.depthNear, 1 / (type.depthFar - type.depthNear)}, type.pad, 0});
    }
    typeBuffer_.update(types.size() * sizeof(GpuCasterType), types.data());
    std::vector<GpuCasterMap> maps;
    for (size_t i = 0; i < maps_.windows().size(); ++i) {
        const MapAtlas::Place& place = maps_.atlas().places()[i];
        maps.push_back({maps_.windows()[i], {place.x, place.y, place.page, place.side}});
    }
    mapBuffer_.update(maps.size() * sizeof(GpuCasterMap), maps.data());
    mapsVersion_ = maps_.version();
}

CasterList::GpuCaster CasterList::casterOf(uint32_t index) const {
    const scenegen::Instance& instance = frame_.scene().scene().instances[index];
    const CasterType& type = maps_.types()[size_t(maps_.typeOf(index))];
    const auto count = int(type.angles.size());
    // One map at the rotation that all instances have is every instance's own.
    const RotationSample sample = sampleRotation(count == 1 ? double(instance.yaw) - type.angles[0] : double(instance.yaw), count);
    const double step = 2 * std::numbers::pi / count;
    const auto first = uint32_t(type.firstMap);
    return {glm::vec4(glm::vec3(glm::dvec3(instance.translation) - frame_.camera().eye), instance.scale),
            {float(std::cos(double(instance.yaw))), float(std::sin(double(instance.yaw)))},
            uint32_t(maps_.typeOf(index)), first + sample.first, sample.weight, first + (sample.first + 1) % uint32_t(count),
            float(-double(sample.weight) * step), float((1 - double(sample.weight)) * step)};
}

bool CasterList::holdsEye(const GpuCaster& caster) const {
    const frame::Camera& camera = frame_.camera();
    const base::Box& box = maps_.types()[caster.type].box;
    const auto toBox = [&](const glm::dvec3& p) {
        const double c = double(caster.cosSinYaw.x), s = double(caster.cosSinYaw.y);
        return glm::dvec3(c * p.x + s * p.y, c * p.y - s * p.x, p.z);
    };
    const double scale = double(caster.place.w), nearPlane = camera.near * std::sqrt(1 + camera.tanX * camera.tanX + camera.tanY * camera.tanY);
    const glm::dvec3 half = glm::dvec3(box.halfSize()) + 1.01 * nearPlane / scale;
    const glm::dvec3 q = toBox(-glm::dvec3(caster.place) / scale) - glm::dvec3(box.centre()), light = toBox(frame_.light());
    double enter = 0, leave = 1e300;
    for (int k = 0; k < 3; ++k) {
        if (std::abs(light[k]) < 1e-12) {
            if (std::abs(q[k]) > half[k]) return false;
            continue;
        }
        const double a = (q[k] - half[k]) / light[k], b = (q[k] + half[k]) / light[k];
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
    }
    return leave >= enter;
}

void CasterList::collect() {
    if (mapsVersion_ != maps_.version()) uploadTypes();
    const gpuscene::GpuScene& scene = frame_.scene();
    const frame::Camera& camera = frame_.camera();
    const base::DBox sceneBox = frame_.relativeSceneBox();
    const std::vector<glm::dvec3> body = viewBody(camera, camera.near, camera.far, sceneBox);
    extrusion_ = extrusionFor(sceneBox, frame_.light());
    const CasterCull cull(maps_.basis(), camera, body, 1e-3 * glm::length(sceneBox.size()));
    casters_.clear();
    for (uint32_t i = 0; i < scene.instanceBoxes().size(); ++i)
        if (maps_.typeOf(i) >= 0 && cull.keep(frame_.relativeBox(i))) casters_.push_back(casterOf(i));
    const auto about = std::stable_partition(casters_.begin(), casters_.end(), [&](const GpuCaster& c) { return !holdsEye(c); });
    notAboutEye_ = size_t(about - casters_.begin());
    casterBuffer_.update(casters_.size() * sizeof(GpuCaster), casters_.data());
}

void CasterList::bind() const {
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, casterBuffer_.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, typeBuffer_.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, mapBuffer_.name());
}

}  // namespace dapple::shadow
