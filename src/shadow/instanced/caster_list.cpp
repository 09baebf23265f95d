#include "shadow/instanced/caster_list.h"

#include "shadow/instanced/far_field.h"
#include "shadow/instanced/reach.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

namespace dapple::shadow {
namespace {

/// Horizontal radius over half the height.
double kappaOf(const CasterType& type) {
    const glm::vec2 reach = glm::max(glm::abs(glm::vec2(type.box.lo)), glm::abs(glm::vec2(type.box.hi)));
    return double(std::max(reach.x, reach.y) / std::max(type.box.halfSize().z, 1e-6f));
}

}  // namespace

CasterList::GpuMap CasterList::mapOf(uint32_t index, double turn, const CasterType& type, double scale) const {
    const CasterMap& map = maps_.maps()[index];
    const MapAtlas::Place& place = maps_.atlas().places()[index];
    const double range = map.depthFar - map.depthNear, c = std::cos(map.pose.elevation), s = std::sin(map.pose.elevation), kappa = kappaOf(type);
    const glm::vec2 perMetre = 0.5f * float(place.side) * glm::vec2(map.window.z, map.window.w);
    return {glm::vec4(perMetre, 0.5f * float(place.side) - map.window.x * perMetre.x, 0.5f * float(place.side) - map.window.y * perMetre.y),
            {place.x, place.y, place.page, place.side}, {-map.depthNear / range, 1 / range, c, s},
            {std::cos(turn), std::sin(turn), 1 / (c * c + kappa * kappa * s * s), range * scale}};
}

CasterList::GpuCaster CasterList::casterOf(uint32_t index) const {
    const scenegen::Instance& instance = maps_.items().instance(index);
    const CasterType& type = maps_.types()[size_t(maps_.typeOf(index))];
    const auto count = int(type.angles.size());
    const auto firstMap = uint32_t(type.firstMap);
    // Where the maps were laid out the light's heading was another: to them it is the instance that has turned.
    const double yaw = double(instance.yaw) - sunTurn_;
    RotationSample sample;
    uint32_t second = 0;
    double turn = 0, secondTurn = 0;
    if (type.ring) {
        sample = sampleRotation(yaw, count);
        second = (sample.first + 1) % uint32_t(count);
        const double step = 2 * std::numbers::pi / count;
        turn = -double(sample.weight) * step;
        secondTurn = (1 - double(sample.weight)) * step;
    } else {
        sample.first = second = uint32_t(maps_.angleOf(type, index));
        turn = secondTurn = std::remainder(maps_.maps()[firstMap + second].pose.yaw - yaw, 2 * std::numbers::pi);  // 0 unless the map is late
    }
    const double scale = double(instance.scale), c = std::cos(double(instance.yaw)), s = std::sin(double(instance.yaw)), kappa = kappaOf(type);
    GpuCaster caster;
    caster.first = mapOf(firstMap + sample.first, turn, type, scale);
    caster.second = mapOf(firstMap + second, secondTurn, type, scale);
    caster.place = glm::vec4(glm::vec3(glm::dvec3(instance.translation) - frame_.camera().eye), 1 / scale);
    caster.box = glm::vec4(type.box.centre(), frame_.scene().scene().prototypes[instance.prototype].transmittance);
    const float stray = strays_[size_t(maps_.typeOf(index))] / instance.scale;
    caster.reach = glm::vec4(type.box.halfSize() + stray, sample.weight);
    const glm::dvec3& l = frame_.light();
    glm::dvec3 light(c * l.x + s * l.y, c * l.y - s * l.x, l.z);
    for (int k = 0; k < 3; ++k)
        if (std::abs(light[k]) < 1e-12) light[k] = 1e-12;
    caster.against = glm::vec4(1.0 / light, kappa * kappa);
    caster.turn = {c, s, scale / double(std::min(caster.first.texels.x, caster.second.texels.x)), scale / double(std::min(caster.first.texels.y, caster.second.texels.y))};
    caster.refers = {firstMap + sample.first, firstMap + second, std::bit_cast<uint32_t>(type.pad), std::bit_cast<uint32_t>(stray)};
    return caster;
}

bool CasterList::holdsEye(const GpuCaster& caster) const {
    const frame::Camera& camera = frame_.camera();
    const auto toBox = [&](const glm::dvec3& p) {
        const double c = double(caster.turn.x), s = double(caster.turn.y);
        return glm::dvec3(c * p.x + s * p.y, c * p.y - s * p.x, p.z);
    };
    const double perMetre = double(caster.place.w), nearPlane = camera.near * std::sqrt(1 + camera.tanX * camera.tanX + camera.tanY * camera.tanY);
    const glm::dvec3 half = glm::dvec3(caster.reach) + 1.01 * nearPlane * perMetre;
    const glm::dvec3 q = toBox(-glm::dvec3(caster.place) * perMetre) - glm::dvec3(caster.box), light = toBox(frame_.light());
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
    double most = 0;
    for (size_t k = 0; k < type.angles.size(); ++k) {
        const MapPose& pose = maps_.maps()[size_t(type.firstMap) + k].pose;
        const MapPose wanted = maps_.poseOf(type, k);
        const double lag = lagOf(pose, {type.ring ? pose.yaw : wanted.yaw, wanted.elevation});
        if (lag < 1e-9) continue;
        const double length = std::min(glm::length(sceneBox.size()), sceneBox.size().z / std::max(std::sin(pose.elevation), 1e-6));
        most = std::max(most, 2 * std::sin(lag / 2) * length);
    }
    return most;
}

void CasterList::collect(FarField* far) {
    readMaps();
    extrusion_ = extrusionFor(frame_.relativeSceneBox(), frame_.light());
    items_ = castersInReach(frame_, maps_.items(), strays_.empty() ? 0 : double(std::ranges::max(strays_)));
    std::erase_if(items_, [&](uint32_t i) { return maps_.typeOf(i) < 0; });
    if (far) far->takeFar(items_, extrusion_);
    upload();
}

void CasterList::update() {
    readMaps();
    upload();
}

void CasterList::readMaps() {
    sunTurn_ = maps_.sunTurn();
    strays_.clear();
    for (const CasterType& type : maps_.types()) strays_.push_back(float(strayOf(type)));
}

void CasterList::upload() {
    casters_.clear();
    for (const uint32_t i : items_) casters_.push_back(casterOf(i));
    const auto about = std::stable_partition(casters_.begin(), casters_.end(), [&](const GpuCaster& c) { return !holdsEye(c); });
    notAboutEye_ = size_t(about - casters_.begin());
    buffer_.update(casters_.size() * sizeof(GpuCaster), casters_.data());
}

std::vector<uint32_t> CasterList::uses() const {
    std::vector<uint32_t> uses(maps_.types().size(), 0);
    for (const uint32_t i : items_) ++uses[size_t(maps_.typeOf(i))];
    return uses;
}

std::vector<bool> CasterList::mapsInUse() const {
    std::vector<bool> used(maps_.maps().size(), false);
    for (const GpuCaster& caster : casters_) used[caster.refers.x] = used[caster.refers.y] = true;
    return used;
}

void CasterList::bind() const {
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, buffer_.name());
}

}  // namespace dapple::shadow
