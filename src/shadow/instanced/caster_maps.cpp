#include "shadow/instanced/caster_maps.h"

#include "shadow/families.h"
#include "shadow/instanced/reach.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dapple::shadow {

using gpuscene::Bucket;

bool castsExactly(const scenegen::Scene& scene, const scenegen::Prototype& prototype, const Settings& settings) {
    const auto limit = size_t(std::stoul(settings.at("exact-casters")));
    return prototype.closed && prototype.transmittance == 0 && prototype.triangles() <= limit &&
           std::none_of(prototype.meshes.begin(), prototype.meshes.end(), [&](const scenegen::Mesh& mesh) { return scene.materials[mesh.material].alphaTested; });
}

CasterMaps::CasterMaps(const frame::Frame& frame, const Settings& settings)
    : frame_(frame), settings_(settings), scene_(frame.scene()), items_(scene_.items()), heading_(sunAngles(frame.light()).heading),
      pad_(kernelRadius(settings) + 1.5), policy_(settings) {
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &bounds_.maxSide);
    glGetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &bounds_.maxPages);
    bounds_.bytes = size_t(std::stoul(settings.at("memory"))) << 20;
    for (const scenegen::Prototype& prototype : scene_.scene().prototypes) exact_.push_back(castsExactly(scene_.scene(), prototype, settings));
    if (scene_.has(Bucket::opaque)) depth_ = gl::Program("shadow/map_depth.vert", "");
    if (scene_.has(Bucket::alphaTested)) depthAlpha_ = gl::Program("shadow/map_depth.vert", "shadow/map_depth.frag", {"ALPHA_TEST"});
    rotated_.parts = items_.parts();
    layOut();
}

void CasterMaps::layOut() {
    plan_ = planMaps(items_, exact_, settings_, bounds_, sunTurn(), [this] { return view(); });
    sides_ = plan_.sides;
    typeOf_ = plan_.sharedTypeOf;
    policy_ = UpdatePolicy(settings_);
    due_.clear();
    maps_.assign(sides_.size(), {});
    rotated_.data.resize(sides_.size());
    rotated_.ranges.resize(sides_.size());
    for (size_t t = 0; t < plan_.types.size(); ++t) {
        CasterType& type = plan_.types[t];
        if (t >= plan_.firstOwn) typeOf_[type.item] = int(t);
        for (size_t k = 0; k < type.angles.size(); ++k) maps_[size_t(type.firstMap) + k].pose = poseOf(type, k);
        fit(type);
    }
    atlas_ = {};
    if (!sides_.empty()) atlas_.arrange(sides_, due_);
    for (size_t map = 0; map < maps_.size(); ++map) due_.insert(int(map));
}

void CasterMaps::resize(const std::vector<int>& wishes) {
    std::vector<int> sides = sidesWithin(wishes, plan_.extents, bounds_);
    if (sides.empty()) sides = plan_.sides;  // the plan's fit, and are the least
    if (sides == sides_) return;
    sides_ = std::move(sides);
    for (CasterType& type : plan_.types) fit(type);
    atlas_.arrange(sides_, due_);
}

size_t CasterMaps::plannedBytes() const {
    return settings_.at("resolution") == "estimate" ? std::min(plan_.wantedBytes, bounds_.bytes) : plan_.bytes;
}

double CasterMaps::sunTurn() const { return std::remainder(sunAngles(frame_.light()).heading - heading_, 2 * std::numbers::pi); }

MapPose CasterMaps::poseOf(const CasterType& type, size_t angle) const {
    const double yaw = type.alone ? double(items_.instance(type.item).yaw) : type.angles[angle];
    return {type.ring ? yaw : yaw - sunTurn(), sunAngles(frame_.light()).elevation};
}

size_t CasterMaps::angleOf(const CasterType& type, uint32_t item) const {
    const double yaw = double(items_.instance(item).yaw);
    const auto own = std::ranges::find_if(type.angles, [&](double angle) { return sameYaw(angle, yaw); });
    return own == type.angles.end() ? 0 : size_t(own - type.angles.begin());
}

std::vector<UpdatePolicy::Map> CasterMaps::wanted() const {
    std::vector<UpdatePolicy::Map> result;
    for (size_t t = 0; t < plan_.types.size(); ++t) {
        const CasterType& type = plan_.types[t];
        const gpuscene::Part& part = items_.parts()[type.part];
        for (size_t k = 0; k < type.angles.size(); ++k) {
            const size_t map = size_t(type.firstMap) + k;
            const double texel = 2 / (double(std::max(maps_[map].window.z, maps_[map].window.w)) * sides_[map]);
            result.push_back({poseOf(type, k), texel, double(part.box.hi.z - part.box.lo.z), uint32_t(t), scene_.scene().prototypes[part.prototype].moving});
        }
    }
    return result;
}

CasterView CasterMaps::view() const {
    CasterView view{std::vector<bool>(items_.size(), false), {}};
    for (const uint32_t i : castersInReach(frame_, items_, 0)) view.inReach[i] = true;
    for (const base::Box& itemBox : items_.boxes()) {
        const base::DBox box = frame_.relative(itemBox);
        const double radius = glm::length(box.halfSize()), distance = std::max(glm::length(box.centre()), radius);
        view.looks.push_back(radius == 0 ? 0 : (frame_.camera().mayContain(box) ? 1.0 : 0.1) * radius / distance);
    }
    return view;
}

bool CasterMaps::choose() {
    std::optional<CasterView> seen;
    const auto look = [&]() -> const CasterView& { return seen ? *seen : seen.emplace(view()); };
    const bool allOwn = settings_.at("mode") == "exact";
    const size_t most = allOwn ? 0 : std::stoul(settings_.at("own"));
    const std::vector<uint32_t> wanted = ownersOf(items_, plan_.types, plan_.sharedTypeOf, most, sunTurn(), look);
    bool other = wanted.size() != (allOwn ? 0 : plan_.types.size() - plan_.firstOwn);
    if (plan_.byView && !other) {
        const std::vector<bool>& reach = look().inReach;
        for (uint32_t i = 0; i < items_.size(); ++i) other |= reach[i] && typeOf_[i] < 0 && !plan_.cascaded[i] && !exact_[items_.part(i).prototype];
    }
    if (other) {
        layOut();
        return true;
    }
    std::vector<uint32_t> waiting;
    for (const uint32_t i : wanted)
        if (typeOf_[i] < int(plan_.firstOwn)) waiting.push_back(i);
    for (size_t t = plan_.firstOwn; t < plan_.types.size() && !waiting.empty(); ++t) {
        CasterType& type = plan_.types[t];
        if (std::ranges::find(wanted, type.item) != wanted.end()) continue;
        typeOf_[type.item] = plan_.sharedTypeOf[type.item];
        const uint32_t item = waiting.front();
        waiting.erase(waiting.begin());
        typeOf_[item] = int(t);
        const int firstMap = type.firstMap;
        type = ownType(items_, item);
        type.firstMap = firstMap;
        maps_[size_t(type.firstMap)].pose = poseOf(type, 0);
        fit(type);
        due_.insert(type.firstMap);
    }
    return false;
}

void CasterMaps::fit(CasterType& type) {
    type.box = items_.parts()[type.part].box;
    double texel = 0;
    for (size_t k = 0; k < type.angles.size(); ++k) {
        const size_t map = size_t(type.firstMap) + k;
        CasterMap& m = maps_[map];
        const LightBasis basis = SunAngles{heading_, m.pose.elevation}.basis();
        const double share = std::max(0.5, 1 - 2 * pad_ / sides_[map]);
        const double c = std::cos(m.pose.yaw), s = std::sin(m.pose.yaw);
        base::DBox bounds;
        for (int corner = 0; corner < 8; ++corner) {
            const glm::dvec3 q(type.box.corner(corner));
            bounds.extend(basis.toLight({c * q.x - s * q.y, s * q.x + c * q.y, q.z}));
        }
        const glm::dvec3 half = glm::max(bounds.halfSize(), glm::dvec3(1e-6)) / glm::dvec3(share, share, 1);
        m.window = {bounds.centre().x, bounds.centre().y, 1 / half.x, 1 / half.y};
        const double side = 2 * std::max(half.x, half.y) / sides_[map];
        m.depthNear = bounds.lo.z - side;
        m.depthFar = bounds.hi.z + side;
        texel = std::max(texel, side);
        rotated_.ranges[map] = {type.part, uint32_t(map), 1};
        rotated_.data[map] = {glm::vec3(0), 1, {float(c), float(s)}};
    }
    // Receivers within the kernel's reach of a shadow's edge need the volume too.
    type.pad = float(pad_ * texel);
    type.box.lo -= type.pad;
    type.box.hi += type.pad;
}

glm::dmat4 CasterMaps::clip(const CasterMap& map, double heading) const {
    const LightBasis basis = SunAngles{heading, map.pose.elevation}.basis();
    const glm::dvec4 w(map.window);
    const double range = map.depthFar - map.depthNear;
    return glm::transpose(glm::dmat4(glm::dvec4(basis.u * w.z, -w.x * w.z), glm::dvec4(basis.v * w.w, -w.y * w.w),
                                     glm::dvec4(basis.l / range, -map.depthNear / range), glm::dvec4(0, 0, 0, 1)));
}

std::vector<LightMatrix> CasterMaps::matrices() const {
    std::vector<LightMatrix> result;
    const double turn = sunTurn();
    for (const CasterType& type : plan_.types)
        for (size_t k = 0; k < type.angles.size(); ++k) {
            const CasterMap& map = maps_[size_t(type.firstMap) + k];
            result.push_back({fmt::format("prototype '{}' rotated by {:.6g} degrees, relative to its own origin",
                                          scene_.scene().prototypes[items_.parts()[type.part].prototype].name, glm::degrees(map.pose.yaw + turn)), clip(map, heading_ + turn)});
        }
    return result;
}

void CasterMaps::render(std::span<const uint32_t> uses, measure::Ledger& tally) {
    for (const int map : due_) policy_.forget(map);
    due_.clear();
    draw(policy_.due(wanted(), uses), tally);
}

void CasterMaps::renderAll(measure::Ledger& tally) {
    due_.clear();
    draw(policy_.renderAll(wanted()), tally);
}

void CasterMaps::draw(const std::vector<int>& maps, measure::Ledger& tally) {
    if (maps.empty()) return;
    auto next = maps.begin();  // sorted, as the types' maps are
    for (CasterType& type : plan_.types) {
        const auto end = std::lower_bound(next, maps.end(), type.firstMap + int(type.angles.size()));
        bool moved = false;
        for (; next != end; ++next) {
            MapPose& pose = maps_[size_t(*next)].pose;
            const MapPose& shown = policy_.shown(*next);
            moved |= pose.yaw != shown.yaw || pose.elevation != shown.elevation;
            pose = shown;
        }
        if (moved) fit(type);
    }
    rotated_.upload();
    const std::vector<gpuscene::DrawList::Range> all = rotated_.ranges;
    glEnable(GL_DEPTH_TEST);
    for (const int map : maps) {
        atlas_.target(map);
        const float one = 1;
        glClearBufferfv(GL_DEPTH, 0, &one);
        tally.texelsWritten += size_t(sides_[size_t(map)]) * size_t(sides_[size_t(map)]);
        rotated_.ranges = {all[size_t(map)]};
        drawCasters(scene_, rotated_, clip(maps_[size_t(map)], heading_), depth_, depthAlpha_, tally);
        countMapFragments(scene_, rotated_, depth_, depthAlpha_, tally);
        const MapAtlas::Place& place = atlas_.places()[size_t(map)];
        countMapTexels(atlas_.texture(), place.page, place.x, place.y, sides_[size_t(map)], tally);
    }
    rotated_.ranges = all;
}

}  // namespace dapple::shadow
