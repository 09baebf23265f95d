#include "shadow/instanced/caster_list.h"

#include "shadow/instanced/far_field.h"
#include "shadow/map/caster_cull.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dapple::shadow {
namespace {

constexpr uint64_t kLeafTriangles = 10'000;  ///< of the hierarchy: some trees

struct GpuCasterType {
    glm::vec4 centre, half;  ///< of the box; centre.w: metres that its maps' shadows may stray from its volume, half.w: κ²
    glm::vec4 more;          ///< transmittance, metres by which the box is larger than the object's
};
static_assert(sizeof(GpuCasterType) == 48);

struct GpuCasterMap {
    glm::vec4 window;  ///< centre, 1 / half size
    glm::vec4 square;  ///< x, y, page, side in the atlas
    glm::vec4 light;   ///< depth along it: nearest, 1 / range; cosine and sine of its sun's elevation
};
static_assert(sizeof(GpuCasterMap) == 48);

}  // namespace

void CasterList::uploadTypes() {
    const scenegen::Scene& scene = frame_.scene().scene();
    std::vector<GpuCasterType> types;
    for (size_t t = 0; t < maps_.types().size(); ++t) {
        const CasterType& type = maps_.types()[t];
        const glm::vec3 half = type.box.halfSize();
        const glm::vec2 reach = glm::max(glm::abs(glm::vec2(type.box.lo)), glm::abs(glm::vec2(type.box.hi)));
        const float kappa = std::max(reach.x, reach.y) / std::max(half.z, 1e-6f);
        types.push_back({glm::vec4(type.box.centre(), strays_[t]), glm::vec4(half, kappa * kappa), {scene.prototypes[type.prototype].transmittance, type.pad, 0, 0}});
    }
    typeBuffer_.update(types.size() * sizeof(GpuCasterType), types.data());
    std::vector<GpuCasterMap> maps;
    for (size_t i = 0; i < maps_.maps().size(); ++i) {
        const CasterMap& map = maps_.maps()[i];
        const MapAtlas::Place& place = maps_.atlas().places()[i];
        maps.push_back({map.window, {place.x, place.y, place.page, place.side}, 
                        {map.depthNear, 1 / (map.depthFar - map.depthNear), std::cos(map.pose.elevation), std::sin(map.pose.elevation)}});
    }
    mapBuffer_.update(maps.size() * sizeof(GpuCasterMap), maps.data());
    mapsVersion_ = maps_.version();
}

CasterList::GpuCaster CasterList::casterOf(uint32_t index) const {
    const scenegen::Instance& instance = frame_.scene().scene().instances[index];
    const CasterType& type = maps_.types()[size_t(maps_.typeOf(index))];
    const auto count = int(type.angles.size());
    // Where the maps were laid out the light's heading was another: to them it is the instance that has turned.
    const double yaw = double(instance.yaw) - sunTurn_;
    const auto first = uint32_t(type.firstMap);
    RotationSample sample;
    double turn = std::remainder(maps_.maps()[first].pose.yaw - yaw, 2 * std::numbers::pi), secondTurn = turn;  // of a lone map: 0 unless it is late
    if (type.ring) {
        sample = sampleRotation(yaw, count);
        const double step = 2 * std::numbers::pi / count;
        turn = -double(sample.weight) * step;
        secondTurn = (1 - double(sample.weight)) * step;
    }
    return {glm::vec4(glm::vec3(glm::dvec3(instance.translation) - frame_.camera().eye), instance.scale),
            {std::cos(double(instance.yaw)), std::sin(double(instance.yaw)), sample.weight, 0},
            {std::cos(turn), std::sin(turn), std::cos(secondTurn), std::sin(secondTurn)},
            {uint32_t(maps_.typeOf(index)), first + sample.first, first + (sample.first + 1) % uint32_t(count), 0}};
}

bool CasterList::holdsEye(const GpuCaster& caster) const {
    const frame::Camera& camera = frame_.camera();
    const base::Box& box = maps_.types()[caster.refers.x].box;
    const auto toBox = [&](const glm::dvec3& p) {
        const double c = double(caster.yaw.x), s = double(caster.yaw.y);
        return glm::dvec3(c * p.x + s * p.y, c * p.y - s * p.x, p.z);
    };
    const double scale = double(caster.place.w), nearPlane = camera.near * std::sqrt(1 + camera.tanX * camera.tanX + camera.tanY * camera.tanY);
    const glm::dvec3 half = glm::dvec3(box.halfSize()) + (1.01 * nearPlane + double(strays_[caster.refers.x])) / scale;
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

/// A shadow falls where its map's light was: beyond the present volume by at most its length times the difference of the two
/// directions.
double CasterList::strayOf(const CasterType& type) const {
    const base::DBox sceneBox = frame_.relativeSceneBox();
    const SunAngles sun = sunAngles(frame_.light());
    double most = 0;
    for (size_t k = 0; k < type.angles.size(); ++k) {
        const MapPose& pose = maps_.maps()[size_t(type.firstMap) + k].pose;
        const double yaw = type.ring ? pose.yaw : double(frame_.scene().scene().instances[type.instance].yaw) - sunTurn_;
        const double lag = lagOf(pose, {yaw, sun.elevation});
        if (lag < 1e-9) continue;
        const double length = std::min(glm::length(sceneBox.size()), sceneBox.size().z / std::max(std::sin(pose.elevation), 1e-6));
        most = std::max(most, 2 * std::sin(lag / 2) * length);
    }
    return most;
}

void CasterList::collect(FarField* far) {
    sunTurn_ = maps_.sunTurn();
    std::vector<float> strays;
    for (const CasterType& type : maps_.types()) strays.push_back(float(strayOf(type)));
    const bool strayed = strays != strays_;
    strays_ = std::move(strays);
    if (strayed || mapsVersion_ != maps_.version()) uploadTypes();
    const frame::Camera& camera = frame_.camera();
    const base::DBox sceneBox = frame_.relativeSceneBox();
    const std::vector<glm::dvec3> body = viewBody(camera, camera.near, camera.far, sceneBox);
    extrusion_ = extrusionFor(sceneBox, frame_.light());
    const double stray = strays_.empty() ? 0 : double(std::ranges::max(strays_));
    const CasterCull cull(lightBasis(frame_.light(), {0, 0, 1}), camera, body, 1e-3 * glm::length(sceneBox.size()) + stray);
    instances_ = cull.kept(frame_.scene().hierarchy(kLeafTriangles, true), frame_.scene().instanceBoxes(), camera.eye);
    std::erase_if(instances_, [&](uint32_t i) { return maps_.typeOf(i) < 0; });
    if (far) far->takeFar(instances_, extrusion_);
    casters_.clear();
    for (const uint32_t i : instances_) casters_.push_back(casterOf(i));
    const auto about = std::stable_partition(casters_.begin(), casters_.end(), [&](const GpuCaster& c) { return !holdsEye(c); });
    notAboutEye_ = size_t(about - casters_.begin());
    casterBuffer_.update(casters_.size() * sizeof(GpuCaster), casters_.data());
}

std::vector<uint32_t> CasterList::uses() const {
    std::vector<uint32_t> uses(maps_.types().size(), 0);
    for (const GpuCaster& caster : casters_) ++uses[caster.refers.x];
    return uses;
}

std::vector<bool> CasterList::mapsInUse() const {
    std::vector<bool> used(maps_.maps().size(), false);
    for (const GpuCaster& caster : casters_) used[caster.refers.y] = used[caster.refers.z] = true;
    return used;
}

void CasterList::bind() const {
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, casterBuffer_.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, typeBuffer_.name());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, mapBuffer_.name());
}

}  // namespace dapple::shadow
