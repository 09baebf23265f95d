#include "shadow/instanced/caster_maps.h"

#include "base/error.h"
#include "shadow/families.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dapple::shadow {

using gpuscene::Bucket;

CasterMaps::CasterMaps(const frame::Frame& frame, const Settings& settings)
    : scene_(frame.scene()),
      // Cached maps must not depend on the view, so neither does their basis.
      basis_(lightBasis(frame.light(), {0, 0, 1})), size_(std::stoi(settings.at("size"))) {
    makeTypes(settings);
    if (types_.empty()) return;
    const auto layers = int(windows_.size());
    GLint limit = 0;
    glGetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &limit);
    if (layers > limit)
        throw base::Error(base::ExitCode::failed, fmt::format("{} maps of {} casters are more than this GL's {} layers: fewer rotations, or mode depth", layers, types_.size(), limit));
    array_ = gl::Texture(GL_DEPTH_COMPONENT32F, size_, size_, layers);
    for (int i = 0; i < layers; ++i) targets_.push_back(gl::makeFramebuffer({}, &array_, i));
    rotated_.upload();
    if (scene_.has(Bucket::opaque)) depth_ = gl::Program("shadow/map_depth.vert", "");
    if (scene_.has(Bucket::alphaTested)) depthAlpha_ = gl::Program("shadow/map_depth.vert", "shadow/map_depth.frag", {"ALPHA_TEST"});
}

void CasterMaps::makeTypes(const Settings& settings) {
    const scenegen::Scene& scene = scene_.scene();
    const int rotations = std::stoi(settings.at("rotations"));
    const bool exact = settings.at("mode") == "exact";
    const double pad = kernelRadius(settings) + 1.5;
    std::vector<int> ofPrototype(scene.prototypes.size(), -1);
    std::vector<bool> turned(scene.prototypes.size(), false);
    for (const scenegen::Instance& instance : scene.instances) {
        const gpuscene::GpuPrototype& prototype = scene_.prototypes()[instance.prototype];
        typeOf_.push_back(-1);
        if (!prototype.castsShadow || prototype.triangles == 0) continue;
        int& known = ofPrototype[instance.prototype];
        if (known < 0 || exact) {
            known = int(types_.size());
            types_.push_back({instance.prototype, 0, {double(instance.yaw)}, prototype.box});
        }
        turned[instance.prototype] = turned[instance.prototype] || double(instance.yaw) != types_[size_t(known)].angles[0];
        typeOf_.back() = known;
    }
    for (CasterType& type : types_) {
        if (!exact && turned[type.prototype]) {
            type.angles.clear();
            for (int k = 0; k < rotations; ++k) type.angles.push_back(2 * std::numbers::pi * k / rotations);
        }
        type.firstLayer = int(windows_.size());
        fit(type, pad);
    }
}

void CasterMaps::fit(CasterType& type, double pad) {
    const double share = std::max(0.5, 1 - 2 * pad / size_);
    double texel = 0;
    type.depthNear = 1e300, type.depthFar = -1e300;
    for (const double angle : type.angles) {
        const double c = std::cos(angle), s = std::sin(angle);
        base::DBox bounds;
        for (int corner = 0; corner < 8; ++corner) {
            const glm::dvec3 q(type.box.corner(corner));
            bounds.extend(basis_.toLight({c * q.x - s * q.y, s * q.x + c * q.y, q.z}));
        }
        const glm::dvec3 half = glm::max(bounds.halfSize(), glm::dvec3(1e-6)) / glm::dvec3(share, share, 1);
        windows_.emplace_back(bounds.centre().x, bounds.centre().y, 1 / half.x, 1 / half.y);
        type.depthNear = std::min(type.depthNear, bounds.lo.z);
        type.depthFar = std::max(type.depthFar, bounds.hi.z);
        texel = std::max(texel, 2 * std::max(half.x, half.y) / size_);
        rotated_.ranges.push_back({type.prototype, uint32_t(rotated_.data.size()), 1});
        rotated_.data.push_back({glm::vec3(0), 1, {float(c), float(s)}});
    }
    // Receivers within the kernel's reach of a shadow's edge need the volume too.
    type.box.lo -= float(pad * texel);
    type.box.hi += float(pad * texel);
    type.depthNear -= texel;
    type.depthFar += texel;
}

glm::dmat4 CasterMaps::clip(const CasterType& type, int k) const {
    const glm::vec4& w = windows_[size_t(type.firstLayer + k)];
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
    glViewport(0, 0, size_, size_);
    glEnable(GL_DEPTH_TEST);
    const std::vector<gpuscene::DrawList::Range> all = rotated_.ranges;
    for (const CasterType& type : types_)
        for (size_t k = 0; k < type.angles.size(); ++k) {
            const size_t layer = size_t(type.firstLayer) + k;
            glBindFramebuffer(GL_FRAMEBUFFER, targets_[layer].name());
            const float one = 1;
            glClearBufferfv(GL_DEPTH, 0, &one);
            tally.texelsWritten += size_t(size_) * size_t(size_);
            rotated_.ranges = {all[layer]};
            drawCasters(scene_, rotated_, clip(type, int(k)), depth_, depthAlpha_, tally);
        }
    rotated_.ranges = all;
}

}  // namespace dapple::shadow
