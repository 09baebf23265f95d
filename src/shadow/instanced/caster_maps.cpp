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
    return prototype.closed && prototype.triangles() <= limit &&
           std::none_of(prototype.meshes.begin(), prototype.meshes.end(), [&](const scenegen::Mesh& mesh) { return scene.materials[mesh.material].alphaTested; });
}

CasterMaps::CasterMaps(const frame::Frame& frame, const Settings& settings)
    : frame_(frame), scene_(frame.scene()),
      // Cached maps must not depend on the view, so neither does their basis.
      basis_(lightBasis(frame.light(), {0, 0, 1})), size_(settings.at("resolution") == "estimate" ? SizeChooser::kLeast : std::stoi(settings.at("size"))), pad_(kernelRadius(settings) + 1.5) {
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
    ++version_;
}

void CasterMaps::addType(CasterType type) {
    type.firstMap = int(windows_.size());
    windows_.resize(windows_.size() + type.angles.size());
    sides_.resize(windows_.size(), size_);
    rotated_.data.resize(windows_.size());
    rotated_.ranges.resize(windows_.size());
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
            shared.push_back({instance.prototype, 0, {double(instance.yaw)}, {}});
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
        addType({instance.prototype, 0, {double(instance.yaw)}, {}});
    }
}

void CasterMaps::setAllDue() {
    for (int map = 0; map < int(windows_.size()); ++map) due_.insert(map);
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
    bool changed = false;
    for (size_t k = 0; k < ownerOf_.size(); ++k) {
        if (chosen[ownerOf_[k]]) continue;
        while (typeOf_[looks[next].second] >= int(firstOwn_)) ++next;
        const uint32_t instance = looks[next].second;
        CasterType& type = types_[firstOwn_ + k];
        typeOf_[ownerOf_[k]] = sharedTypeOf_[ownerOf_[k]];
        typeOf_[instance] = int(firstOwn_ + k);
        ownerOf_[k] = instance;
        type.prototype = scene.instances[instance].prototype;
        type.angles = {double(scene.instances[instance].yaw)};
        fit(type);
        due_.insert(type.firstMap);
        changed = true;
    }
    version_ += changed;
}

void CasterMaps::fit(CasterType& type) {
    type.box = scene_.prototypes()[type.prototype].box;
    double texel = 0;
    type.depthNear = 1e300, type.depthFar = -1e300;
    for (size_t k = 0; k < type.angles.size(); ++k) {
        const size_t map = size_t(type.firstMap) + k;
        const double share = std::max(0.5, 1 - 2 * pad_ / sides_[map]);
        const double c = std::cos(type.angles[k]), s = std::sin(type.angles[k]);
        base::DBox bounds;
        for (int corner = 0; corner < 8; ++corner) {
            const glm::dvec3 q(type.box.corner(corner));
            bounds.extend(basis_.toLight({c * q.x - s * q.y, s * q.x + c * q.y, q.z}));
        }
        const glm::dvec3 half = glm::max(bounds.halfSize(), glm::dvec3(1e-6)) / glm::dvec3(share, share, 1);
        windows_[map] = {bounds.centre().x, bounds.centre().y, 1 / half.x, 1 / half.y};
        type.depthNear = std::min(type.depthNear, bounds.lo.z);
        type.depthFar = std::max(type.depthFar, bounds.hi.z);
        texel = std::max(texel, 2 * std::max(half.x, half.y) / sides_[map]);
        rotated_.ranges[map] = {type.prototype, uint32_t(map), 1};
        rotated_.data[map] = {glm::vec3(0), 1, {float(c), float(s)}};
    }
    // Receivers within the kernel's reach of a shadow's edge need the volume too.
    type.pad = float(pad_ * texel);
    type.box.lo -= type.pad;
    type.box.hi += type.pad;
    type.depthNear -= texel;
    type.depthFar += texel;
}

glm::dmat4 CasterMaps::clip(const CasterType& type, int k) const {
    const glm::vec4& w = windows_[size_t(type.firstMap + k)];
    const double range = type.depthFar - type.depthNear;
    return glm::transpose(glm::dmat4(glm::dvec4(basis_.u * double(w.z), -double(w.x) * w.z), glm::dvec4(basis_.v * double(w.w), -double(w.y) * w.w),
                                     glm::dvec4(basis_.l / range, -type.depthNear / range), glm::dvec4(0, 0, 0, 1)));
}

std::vector<LightMatrix> CasterMaps::matrices() const {
    std::vector<LightMatrix> result;
    for (const CasterType& type : types_)
        for (size_t k = 0; k < type.angles.size(); ++k)
            result.push_back({fmt::format("prototype '{}' rotated by {:.6g} degrees, relative to its own origin",
                                          scene_.scene().prototypes[type.prototype].name, glm::degrees(type.angles[k])), clip(type, int(k))});
    return result;
}

void CasterMaps::render(measure::Ledger& tally) {
    if (due_.empty()) return;
    rotated_.upload();
    const std::vector<gpuscene::DrawList::Range> all = rotated_.ranges;
    glEnable(GL_DEPTH_TEST);
    for (const CasterType& type : types_)
        for (size_t k = 0; k < type.angles.size(); ++k) {
            const int map = type.firstMap + int(k);
            if (!due_.contains(map)) continue;
            atlas_.target(map);
            const float one = 1;
            glClearBufferfv(GL_DEPTH, 0, &one);
            tally.texelsWritten += size_t(sides_[size_t(map)]) * size_t(sides_[size_t(map)]);
            rotated_.ranges = {all[size_t(map)]};
            drawCasters(scene_, rotated_, clip(type, int(k)), depth_, depthAlpha_, tally);
        }
    rotated_.ranges = all;
    due_.clear();
}

}  // namespace dapple::shadow
