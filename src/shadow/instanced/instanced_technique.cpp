// Instanced shadow maps (Buntin & Stamminger 2007): per caster type, maps of the object rotated about the vertical in
// equal steps; per instance, the bounding shadow volume of its box picks the pixels that look one up.
#include "shadow/families.h"

#include "shadow/instanced/volume.h"
#include "shadow/map/caster_cull.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dapple::shadow {
namespace {

using gpuscene::Bucket;

class InstancedTechnique final : public Technique {
public:
    InstancedTechnique(frame::Frame& frame, const Settings& settings)
        : frame_(frame), settings_(settings), size_(std::stoi(settings.at("size"))),
          rotations_(frame.scene().facts().rotated ? std::stoi(settings.at("rotations")) : 1),
          // Cached maps must not depend on the view, so neither does their basis.
          basis_(lightBasis(frame.light(), {0, 0, 1})) {
        makeTypes();
        makePrograms();
        const auto& camera = frame.camera();
        depthCopy_ = gl::Texture(GL_R32F, camera.width, camera.height);
        const gl::Texture* begin[] = {&frame.visibility(), &depthCopy_};
        const gl::Texture* volume[] = {&frame.visibility()};
        beginTarget_ = gl::makeFramebuffer(begin, nullptr);
        volumeTarget_ = gl::makeFramebuffer(volume, &frame.depth());
        corners_ = gl::Buffer::of<uint32_t>(boxShadowVolume());
        const bool compare = settings.at("mode") != "depth", linear = settings.at("filter") != "nearest";
        sampler_ = gl::makeSampler({GLenum(linear ? GL_LINEAR : GL_NEAREST), false, GL_CLAMP_TO_BORDER, compare});
        if (types_.empty()) return;
        map_ = gl::Texture(GL_DEPTH_COMPONENT32F, size_, size_, int(types_.size()) * rotations_);
        for (int i = 0; i < map_.layers(); ++i) targets_.push_back(gl::makeFramebuffer({}, &map_, i));
        if (cached()) {
            measure::Ledger ignored;
            gl::resetState();
            renderMaps(ignored);
            gl::resetState();
        }
    }

    std::vector<frame::Pass> passes() override {
        std::string mapsLeftOut, volumesLeftOut;
        if (types_.empty()) mapsLeftOut = volumesLeftOut = "the scene has no caster";
        else if (cached()) mapsLeftOut = "cached: neither the sun nor a caster's shape has changed";
        std::vector<frame::Pass> passes{
            {"maps", {}, {"maps"}, fmt::format("{} rotations of each caster type", rotations_), mapsLeftOut,
             [this](measure::Ledger& tally) { renderMaps(tally); }},
            {"begin", {"gbuffer", "depth"}, {"visibility", "depth-copy"}, "lit where the surface faces the sun; depth to read", "",
             [this](measure::Ledger& tally) { begin(tally); }},
            {"volumes", {"visibility", "depth-copy"}, {"visibility"}, "look-ups inside each instance's bounding shadow volume",
             volumesLeftOut, [this](measure::Ledger& tally) { renderVolumes(volumes_, tally); }}};
        if (rotations_ == 1 && settings_.at("rotations") != "1")
            passes.insert(passes.begin(), frame::Pass{"maps.rotated", {}, {}, "maps of rotated casters", "no caster is rotated: one map per type serves", {}});
        return passes;
    }

    std::vector<LightMatrix> matrices() const override {
        std::vector<LightMatrix> result;
        for (const Type& type : types_)
            for (int k = 0; k < rotations_; ++k)
                result.push_back({fmt::format("prototype '{}' rotated by {:.6g} degrees, relative to its own origin",
                                              frame_.scene().scene().prototypes[type.prototype].name, 360.0 * k / rotations_),
                                  mapClip(type, k)});
        return result;
    }

    const gl::Texture* map() const override { return map_.name() ? &map_ : nullptr; }

    bool countOverdraw() override {
        const gl::Texture* colours[] = {&frame_.overdraw()};
        const gl::Framebuffer target = gl::makeFramebuffer(colours, &frame_.depth());
        gl::resetState();
        glBindFramebuffer(GL_FRAMEBUFFER, target.name());
        const float zero[4] = {0, 0, 0, 0};
        glClearBufferfv(GL_COLOR, 0, zero);
        glEnable(GL_BLEND);
        glBlendFunc(GL_ONE, GL_ONE);
        measure::Ledger ignored;
        if (!types_.empty()) submitVolumes(count_, ignored);
        gl::resetState();
        return true;
    }

private:
    /// A prototype that casts, with its windows: one per rotation, (centre u, centre v, 1/half u, 1/half v).
    struct Type {
        uint32_t prototype;
        int firstLayer;
        base::Box box;               // prototype space, padded by the kernel
        std::vector<glm::vec4> windows;
        double depthNear, depthFar;  // metres along l from the prototype's origin, common to all rotations
        gpuscene::DrawList rotated;  // the prototype at each rotation
    };

    bool cached() const { return settings_.at("update") == "cached"; }
    double angle(int k) const { return 2 * std::numbers::pi * k / rotations_; }

    void makeTypes() {
        const gpuscene::GpuScene& scene = frame_.scene();
        std::vector<bool> used(scene.prototypes().size());
        for (const scenegen::Instance& instance : scene.scene().instances) used[instance.prototype] = true;
        for (uint32_t p = 0; p < used.size(); ++p) {
            const gpuscene::GpuPrototype& prototype = scene.prototypes()[p];
            if (!used[p] || !prototype.castsShadow || prototype.triangles == 0) continue;
            Type type{p, int(types_.size()) * rotations_, prototype.box, {}, 1e300, -1e300, {}};
            const double pad = kernelRadius(settings_) + 1.5, share = std::max(0.5, 1 - 2 * pad / size_);
            double texel = 0;
            for (int k = 0; k < rotations_; ++k) {
                const double c = std::cos(angle(k)), s = std::sin(angle(k));
                base::DBox bounds;
                for (int corner = 0; corner < 8; ++corner) {
                    const glm::dvec3 q(prototype.box.corner(corner));
                    bounds.extend(basis_.toLight({c * q.x - s * q.y, s * q.x + c * q.y, q.z}));
                }
                const glm::dvec3 half = glm::max(bounds.halfSize(), glm::dvec3(1e-6)) / glm::dvec3(share, share, 1);
                type.windows.emplace_back(bounds.centre().x, bounds.centre().y, 1 / half.x, 1 / half.y);
                type.depthNear = std::min(type.depthNear, bounds.lo.z);
                type.depthFar = std::max(type.depthFar, bounds.hi.z);
                texel = std::max(texel, 2 * std::max(half.x, half.y) / size_);
                type.rotated.data.push_back({glm::vec3(0), 1, {float(c), float(s)}});
            }
            // Receivers within the kernel's reach of a shadow's edge need the volume too.
            type.box.lo -= float(pad * texel);
            type.box.hi += float(pad * texel);
            type.depthNear -= texel;
            type.depthFar += texel;
            type.rotated.upload();
            types_.push_back(std::move(type));
        }
    }

    void makePrograms() {
        const gpuscene::GpuScene& scene = frame_.scene();
        if (scene.has(Bucket::opaque)) depth_ = gl::Program("shadow/map_depth.vert", "");
        if (scene.has(Bucket::alphaTested)) depthAlpha_ = gl::Program("shadow/map_depth.vert", "shadow/map_depth.frag", {"ALPHA_TEST"});
        begin_ = gl::Program("passes/fullscreen.vert", "shadow/instanced_begin.frag");
        std::vector<std::string> defines = samplingDefines(settings_);
        const std::string& mode = settings_.at("mode");
        defines.push_back(fmt::format("MODE {}", mode == "nearest" ? 0 : mode == "blend" ? 1 : 2));
        if (settings_.at("sample-frame") == "B") defines.push_back("SAMPLE_ROTATED");
        volumes_ = gl::Program("shadow/instanced.vert", "shadow/instanced.frag", defines);
        count_ = gl::Program("shadow/instanced.vert", "passes/count.frag");
        array_ = gl::makeVertexArray();
        const auto attribute = [&](GLuint index, GLint count, GLuint binding, GLuint offset) {
            glEnableVertexArrayAttrib(array_.name(), index);
            glVertexArrayAttribFormat(array_.name(), index, count, GL_FLOAT, GL_FALSE, offset);
            glVertexArrayAttribBinding(array_.name(), index, binding);
            glVertexArrayBindingDivisor(array_.name(), binding, 1);
        };
        attribute(3, 4, 0, 0);
        attribute(4, 2, 0, offsetof(gpuscene::InstanceData, cosSinYaw));
        attribute(5, 2, 1, 0);
    }

    glm::dmat4 mapClip(const Type& type, int k) const {
        const glm::vec4& w = type.windows[size_t(k)];
        const double range = type.depthFar - type.depthNear;
        return glm::transpose(glm::dmat4(glm::dvec4(basis_.u * double(w.z), -double(w.x) * w.z), glm::dvec4(basis_.v * double(w.w), -double(w.y) * w.w),
                                         glm::dvec4(basis_.l / range, -type.depthNear / range), glm::dvec4(0, 0, 0, 1)));
    }

    void renderMaps(measure::Ledger& tally) {
        glViewport(0, 0, size_, size_);
        glEnable(GL_DEPTH_TEST);
        for (Type& type : types_)
            for (int k = 0; k < rotations_; ++k) {
                glBindFramebuffer(GL_FRAMEBUFFER, targets_[size_t(type.firstLayer + k)].name());
                const float one = 1;
                glClearBufferfv(GL_DEPTH, 0, &one);
                tally.texelsWritten += size_t(size_) * size_t(size_);
                type.rotated.ranges = {{type.prototype, uint32_t(k), 1}};
                drawCasters(frame_.scene(), type.rotated, mapClip(type, k), depth_, depthAlpha_, tally);
            }
    }

    void begin(measure::Ledger& tally) {
        glBindFramebuffer(GL_FRAMEBUFFER, beginTarget_.name());
        glViewport(0, 0, frame_.camera().width, frame_.camera().height);
        frame_.setView(begin_);
        begin_.use();
        frame_.bindGeometry();
        frame_.drawFullscreen();
        ++tally.drawCalls;
    }

    /// Instances whose shadow volume can meet a receiver in view.
    void collectCasters() {
        const gpuscene::GpuScene& scene = frame_.scene();
        const frame::Camera& camera = frame_.camera();
        const base::DBox sceneBox = frame_.relativeSceneBox();
        const std::vector<glm::dvec3> body = viewBody(camera, camera.near, camera.far, sceneBox);
        double farthest = -1e300, nearest = 1e300;
        for (int corner = 0; corner < 8; ++corner) {
            farthest = std::max(farthest, glm::dot(sceneBox.corner(corner), frame_.light()));
            nearest = std::min(nearest, glm::dot(sceneBox.corner(corner), frame_.light()));
        }
        extrusion_ = farthest - nearest;  // every volume ends behind the whole scene
        floor_ = sceneBox.empty() ? 0 : sceneBox.lo.z - 1e-3 * glm::length(sceneBox.size());
        const CasterCull cull(basis_, camera, body, 1e-3 * glm::length(sceneBox.size()));
        scene.collect(camera.eye, [&](uint32_t i) {
            return scene.prototypes()[scene.scene().instances[i].prototype].castsShadow && cull.keep(frame_.relativeBox(i));
        }, casters_);
        std::vector<glm::vec2> rotations;
        for (const uint32_t i : casters_.instances) {
            const RotationSample sample = sampleRotation(double(scene.scene().instances[i].yaw), rotations_);
            rotations.emplace_back(float(sample.first), sample.weight);
        }
        rotationBuffer_.update(rotations.size() * sizeof(glm::vec2), rotations.data());
    }

    void submitVolumes(const gl::Program& program, measure::Ledger& tally) {
        collectCasters();
        glViewport(0, 0, frame_.camera().width, frame_.camera().height);
        // z-fail: back faces that lie behind the scene (smaller depth, as z is reversed), whatever side the eye is on.
        glEnable(GL_DEPTH_TEST);
        glDepthFunc(GL_LESS);
        glDepthMask(GL_FALSE);
        glEnable(GL_DEPTH_CLAMP);
        glEnable(GL_CULL_FACE);
        glCullFace(GL_FRONT);
        frame_.setView(program);
        program.set("uExtrusion", float(extrusion_));
        program.set("uFloor", float(floor_));
        program.set("uBasisU", glm::vec3(basis_.u));
        program.set("uBasisV", glm::vec3(basis_.v));
        program.set("uSize", float(size_));
        program.set("uRotations", rotations_);
        program.set("uBiasScale", std::stof(settings_.at("bias-scale")));
        program.use();
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, corners_.name());
        glVertexArrayVertexBuffer(array_.name(), 0, casters_.buffer.name(), 0, sizeof(gpuscene::InstanceData));
        glVertexArrayVertexBuffer(array_.name(), 1, rotationBuffer_.name(), 0, sizeof(glm::vec2));
        glBindVertexArray(array_.name());
        for (const gpuscene::DrawList::Range& range : casters_.ranges) {
            const auto type = std::find_if(types_.begin(), types_.end(), [&](const Type& t) { return t.prototype == range.prototype; });
            program.set("uBoxCentre", type->box.centre());
            program.set("uBoxHalf", type->box.halfSize());
            program.set("uFirstLayer", type->firstLayer);
            program.set("uDepthRange", glm::vec2(type->depthNear, 1 / (type->depthFar - type->depthNear)));
            program.set("uWindows[0]", std::span<const glm::vec4>(type->windows));
            glDrawArraysInstancedBaseInstance(GL_TRIANGLES, 0, 72, GLsizei(range.count), range.first);
            ++tally.drawCalls;
            tally.trianglesSubmitted += 24 * size_t(range.count);
        }
    }

    void renderVolumes(const gl::Program& program, measure::Ledger& tally) {
        glBindFramebuffer(GL_FRAMEBUFFER, volumeTarget_.name());
        glColorMask(GL_TRUE, GL_FALSE, GL_FALSE, GL_FALSE);  // validity stays
        glEnable(GL_BLEND);
        glBlendEquation(GL_MIN);
        frame_.bindGeometry();
        glBindTextureUnit(2, depthCopy_.name());
        glBindTextureUnit(3, map_.name());
        glBindSampler(3, sampler_.name());
        submitVolumes(program, tally);
    }

    frame::Frame& frame_;
    Settings settings_;
    int size_, rotations_;
    LightBasis basis_;
    std::vector<Type> types_;
    gl::Texture map_, depthCopy_;
    std::vector<gl::Framebuffer> targets_;
    gl::Framebuffer beginTarget_, volumeTarget_;
    gl::Sampler sampler_;
    gl::VertexArray array_;
    gl::Buffer corners_, rotationBuffer_;
    gl::Program depth_, depthAlpha_, begin_, volumes_, count_;
    gpuscene::DrawList casters_;
    double extrusion_ = 0, floor_ = 0;  // metres; floor_ relative to the eye
};

}  // namespace

std::unique_ptr<Technique> makeInstanced(frame::Frame& frame, const Settings& settings) {
    return std::make_unique<InstancedTechnique>(frame, settings);
}

}  // namespace dapple::shadow
