#include "shadow/instanced/caster_maps.h"

#include "shadow/families.h"
#include "shadow/instanced/resolution.h"

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
    : frame_(frame), scene_(frame.scene()),
      heading_(sunAngles(frame.light()).heading), policy_(settings),
      size_(settings.at("resolution") == "estimate" ? SizeChooser::kLeast : std::stoi(settings.at("size"))), pad_(kernelRadius(settings) + 1.5) {
    makeTypes(settings);
    if (types_.empty()) return;
    atlas_.arrange(sides_, due_);
    if (scene_.has(Bucket::opaque)) depth_ = gl::Program("shadow/map_depth.vert", "");
    if (scene_.has(Bucket::alphaTested)) depthAlpha_ = gl::Program("shadow/map_depth.vert", "shadow/map_depth.frag", {"ALPHA_TEST"});
    choose();
}

void CasterMaps::resize(const std::vector<int>& sides) {
    if (sides == sides_) return;
    sides_ = sides;
    for (CasterType& type : types_) fit(type);
    atlas_.arrange(sides_, due_);
}

void CasterMaps::addType(CasterType type) {
    type.firstMap = int(maps_.size());
    for (size_t k = 0; k < type.angles.size(); ++k) maps_.push_back({poseOf(type, k), {}});
    sides_.resize(maps_.size(), size_);
    rotated_.data.resize(maps_.size());
    rotated_.ranges.resize(maps_.size());
    fit(type);
    types_.push_back(std::move(type));
}

void CasterMaps::makeTypes(const Settings& settings) {
    const scenegen::Scene& scene = scene_.scene();
    const int rotations = std::stoi(settings.at("rotations"));
    std::vector<int> ofPrototype(scene.prototypes.size(), -1);
    std::vector<bool> exact;
    for (const scenegen::Prototype& prototype : scene.prototypes) exact.push_back(castsExactly(scene, prototype, settings));
    std::vector<CasterType> shared;
    std::vector<bool> turned;
    std::vector<uint32_t> casting;
    for (uint32_t i = 0; i < scene.instances.size(); ++i) {
        const scenegen::Instance& instance = scene.instances[i];
        const gpuscene::GpuPrototype& prototype = scene_.prototypes()[instance.prototype];
        typeOf_.push_back(-1);
        if (!prototype.castsShadow || prototype.triangles == 0 || exact[instance.prototype]) continue;
        casting.push_back(i);
        int& known = ofPrototype[instance.prototype];
        if (known < 0) {
            known = int(shared.size());
            shared.push_back({instance.prototype, i, 0, {double(instance.yaw)}, false, {}, 0});
            turned.push_back(false);
        }
        turned[size_t(known)] = turned[size_t(known)] || double(instance.yaw) != shared[size_t(known)].angles[0];
        typeOf_.back() = known;
    }
    // With a map for every instance nothing is shared.
    const size_t own = settings.at("mode") == "exact" ? casting.size() : std::min(size_t(std::stoi(settings.at("own"))), casting.size());
    if (own < casting.size())
        for (size_t k = 0; k < shared.size(); ++k) {
            if (turned[k]) {
                shared[k].angles.clear();
                shared[k].ring = true;
                for (int r = 0; r < rotations; ++r) shared[k].angles.push_back(2 * std::numbers::pi * r / rotations);
            }
            addType(shared[k]);
        }
    firstOwn_ = types_.size();
    sharedTypeOf_ = typeOf_;
    for (size_t k = 0; k < own; ++k) {
        const scenegen::Instance& instance = scene.instances[casting[k]];
        ownerOf_.push_back(casting[k]);
        typeOf_[casting[k]] = int(types_.size());
        addType({instance.prototype, casting[k], 0, {double(instance.yaw)}, false, {}, 0});
    }
}

double CasterMaps::sunTurn() const { return std::remainder(sunAngles(frame_.light()).heading - heading_, 2 * std::numbers::pi); }

MapPose CasterMaps::poseOf(const CasterType& type, size_t k) const {
    const double yaw = type.ring ? type.angles[k] : double(scene_.scene().instances[type.instance].yaw) - sunTurn();
    return {yaw, sunAngles(frame_.light()).elevation};
}

std::vector<UpdatePolicy::Map> CasterMaps::wanted() const {
    std::vector<UpdatePolicy::Map> result;
    for (size_t t = 0; t < types_.size(); ++t) {
        const CasterType& type = types_[t];
        const base::Box& box = scene_.prototypes()[type.prototype].box;
        for (size_t k = 0; k < type.angles.size(); ++k) {
            const size_t map = size_t(type.firstMap) + k;
            const double texel = 2 / (double(std::max(maps_[map].window.z, maps_[map].window.w)) * sides_[map]);
            result.push_back({poseOf(type, k), texel, double(box.hi.z - box.lo.z), uint32_t(t), scene_.scene().prototypes[type.prototype].moving});
        }
    }
    return result;
}

void CasterMaps::choose() {
    const scenegen::Scene& scene = scene_.scene();
    if (ownerOf_.empty() || firstOwn_ == 0) return;  // none, or all have their own
    std::vector<std::pair<double, uint32_t>> looks;  // minus the sine of half the angle that it fills
    for (uint32_t i = 0; i < sharedTypeOf_.size(); ++i) {
        if (sharedTypeOf_[i] < 0) continue;
        const base::DBox box = frame_.relativeBox(i);
        const double radius = glm::length(box.halfSize()), distance = std::max(glm::length(box.centre()), radius);
        const bool seen = frame_.camera().mayContain(box);
        looks.emplace_back(-(seen ? 1.0 : 0.1) * radius / distance, i);
    }
    std::partial_sort(looks.begin(), looks.begin() + std::ptrdiff_t(ownerOf_.size()), looks.end());
    std::vector<bool> chosen(sharedTypeOf_.size(), false);
    for (size_t k = 0; k < ownerOf_.size(); ++k) chosen[looks[k].second] = true;
    size_t next = 0;
    for (size_t k = 0; k < ownerOf_.size(); ++k) {
        if (chosen[ownerOf_[k]]) continue;
        while (typeOf_[looks[next].second] >= int(firstOwn_)) ++next;
        const uint32_t instance = looks[next].second;
        CasterType& type = types_[firstOwn_ + k];
        typeOf_[ownerOf_[k]] = sharedTypeOf_[ownerOf_[k]];
        typeOf_[instance] = int(firstOwn_ + k);
        ownerOf_[k] = instance;
        type.prototype = scene.instances[instance].prototype;
        type.instance = instance;
        type.angles = {double(scene.instances[instance].yaw)};
        maps_[size_t(type.firstMap)].pose = poseOf(type, 0);
        fit(type);
        due_.insert(type.firstMap);
    }
}

void CasterMaps::fit(CasterType& type) {
    type.box = scene_.prototypes()[type.prototype].box;
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
        rotated_.ranges[map] = {type.prototype, uint32_t(map), 1};
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
    for (const CasterType& type : types_)
        for (size_t k = 0; k < type.angles.size(); ++k) {
            const CasterMap& map = maps_[size_t(type.firstMap) + k];
            result.push_back({fmt::format("prototype '{}' rotated by {:.6g} degrees, relative to its own origin",
                                          scene_.scene().prototypes[type.prototype].name, glm::degrees(map.pose.yaw + turn)), clip(map, heading_ + turn)});
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
    for (CasterType& type : types_) {
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
