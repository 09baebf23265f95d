// The family of shadow maps over the scene: fit × split × bias × filter (Williams 1978; Zhang et al. 2006 for the
// split; fit.cpp for the fits).
#include "shadow/families.h"

#include "shadow/culling.h"
#include "shadow/map/caster_cull.h"
#include "shadow/map/receiver_mask.h"
#include "visibility/receiver_pyramid.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numbers>
#include <optional>

namespace dapple::shadow {
namespace {

using gpuscene::Attributes;
using gpuscene::Bucket;

/// Triangles in a leaf of the hierarchy that bounds the whole scene.
constexpr uint64_t kBoundsLeaf = 10'000;

class MapTechnique final : public Technique {
public:
    MapTechnique(frame::Frame& frame, const Settings& settings, std::function<bool(uint32_t)> casts)
        : frame_(frame), settings_(settings), casts_(std::move(casts)), size_(std::stoi(settings.at("size"))), layers_(std::stoi(settings.at("cascades"))),
          kind_(settings.at("fit") == "scene" ? FitKind::scene : settings.at("fit") == "lispsm" ? FitKind::lispsm : FitKind::frustum),
          cascades_(size_t(layers_)) {
        if (frame.scene().facts().casters) {
            map_ = gl::Texture(is("mask-test", "stencil") ? GL_DEPTH32F_STENCIL8 : GL_DEPTH_COMPONENT32F, size_, size_, layers_);
            for (int i = 0; i < layers_; ++i) cascades_[size_t(i)].target = gl::makeFramebuffer({}, &map_, i);
        }
        const bool linear = settings.at("filter") != "nearest";
        sampler_ = gl::makeSampler({GLenum(linear ? GL_LINEAR : GL_NEAREST), false, GL_CLAMP_TO_BORDER, true});
        if (frame.scene().has(Bucket::opaque)) depth_ = gl::Program("shadow/map_depth.vert", "");
        if (frame.scene().has(Bucket::alphaTested))
            depthAlpha_ = gl::Program("shadow/map_depth.vert", "shadow/map_depth.frag", {"ALPHA_TEST"});
        std::vector<std::string> defines = samplingDefines(settings);
        if (kind_ == FitKind::lispsm) defines.push_back("WARPED");
        resolve_ = gl::Program("passes/fullscreen.vert", "shadow/map_resolve.frag", defines);
        if (!map_.name()) return;
        if (is("cull", "pyramid")) {
            pyramid_.emplace(frame.scene(), size_, layers_, kind_ == FitKind::lispsm);
            scatter_ = gl::Program::compute("shadow/map_receivers.comp", defines);
        }
        if (is("cull", "chc") || is("cull", "chcpp") || is("cull", "receivers"))
            for (Cascade& c : cascades_) c.culling = std::make_unique<visibility::ViewCulling>(frame.scene(), cullOptions(settings, settings.at("cull"), true));
        if (is("cull", "hiz"))
            for (int i = 0; i < layers_; ++i) {
                cascades_[size_t(i)].layer = map_.view(i);
                cascades_[size_t(i)].hiz = std::make_unique<visibility::HizCulling>(frame.scene(), true, false);
            }
        if (is("cull", "receivers")) mask_.emplace(frame, settings, map_, defines);
    }

    std::vector<frame::Pass> passes() override {
        fitCascades();
        std::vector<frame::Pass> passes;
        std::vector<std::string> reads{"gbuffer", "depth"}, mapReads;
        if (mask_) mapReads = reads;
        if (marksReceivers()) {
            const bool some = std::any_of(cascades_.begin(), cascades_.end(), [&](const Cascade& c) { return needed(c).empty(); });
            passes.push_back({"receivers", reads, {"receivers"}, "where the look-ups of the visible receivers fall in the maps, and how far from the sun",
                              some ? "" : needed(cascades_[0]), [this](measure::Ledger& tally) { markReceivers(tally); }});
            mapReads.push_back("receivers");
        }
        for (int i = 0; i < layers_; ++i) {
            const std::string name = layers_ == 1 ? "map" : fmt::format("map{}", i);
            const std::string leftOut = needed(cascades_[size_t(i)]);
            passes.push_back({name, mapReads, {name}, "depth of the casters seen from the sun", leftOut,
                              [this, i](measure::Ledger& tally) { renderMap(i, tally); }, cascades_[size_t(i)].culling != nullptr});
            if (leftOut.empty()) reads.push_back(name);
        }
        passes.push_back({"resolve", reads, {"visibility"}, "one comparison per pixel", "",
                          [this](measure::Ledger& tally) { resolve(tally); }});
        return passes;
    }

    std::string fallback() const override {
        for (const Cascade& c : cascades_)
            if (!c.fit.fallback.empty()) return c.fit.fallback;
        return {};
    }

    std::vector<LightMatrix> matrices() const override {
        std::vector<LightMatrix> result;
        for (size_t i = 0; i < cascades_.size(); ++i)
            if (!cascades_[i].fit.empty) result.push_back({fmt::format("map{}", i), cascades_[i].fit.clipFromRelative});
        return result;
    }

    std::optional<Casters> castersDrawn() const override {
        Casters sum;
        const auto add = [&](std::span<const uint32_t> instances) {
            sum.instances += instances.size();
            for (const uint32_t i : instances) sum.triangles += frame_.scene().prototypes()[frame_.scene().scene().instances[i].prototype].triangles;
        };
        for (const Cascade& c : cascades_) {
            if (!needed(c).empty()) continue;
            if (pyramid_ || c.hiz) {
                const gpuscene::InstanceTable::Drawn drawn = c.hiz ? c.hiz->drawn() : frame_.scene().instanceTable().read(c.casters);
                sum.instances += drawn.instances;
                sum.triangles += drawn.triangles;
                continue;
            }
            add(c.casters.instances);  // with a mask, the receivers in sight
            if (c.culling) add(c.culling->instances());
        }
        return sum;
    }

    const gl::Texture* map() const override { return map_.name() ? &map_ : nullptr; }

private:
    struct Cascade {
        LightFit fit;
        std::vector<glm::dvec3> body;
        double far = 0;  // metres of eye depth where the next cascade begins
        gl::Framebuffer target;
        gpuscene::DrawList casters, receivers;
        std::unique_ptr<visibility::HizCulling> hiz;
        gl::Texture layer;  // of the map, for hiz
        std::unique_ptr<visibility::ViewCulling> culling;  // where occlusion queries decide
    };

    bool is(const char* axisName, const char* value) const { return settings_.at(axisName) == value; }
    /// Whether a pass of its own finds where look-ups fall, before any map.
    bool marksReceivers() const { return pyramid_ || (mask_ && mask_->scatters()); }

    /// Why a cascade's map is not needed; empty when it is.
    std::string needed(const Cascade& cascade) const {
        if (!frame_.scene().facts().casters) return "the scene has no caster";
        if (cascade.fit.empty) return "no receiver can lie in this slice of the view";
        return {};
    }

    /// Cheap enough to be redone in every frame, as a moving camera would have to.
    void fitCascades() {
        const frame::Camera& camera = frame_.camera();
        basis_ = lightBasis(frame_.light(), camera.forward);
        const base::DBox sceneBox = frame_.relativeSceneBox();
        base::DBox sceneBounds;
        if (kind_ == FitKind::scene) {  // tighter than the box of everything, which the sun sees askew
            const gpuscene::Hierarchy& instances = frame_.scene().hierarchy(kBoundsLeaf, false);
            const glm::dvec3 axes[] = {basis_.u, basis_.v, basis_.l};
            for (int k = 0; k < 3; ++k) {
                const double eye = glm::dot(camera.eye, axes[k]);
                sceneBounds.lo[k] = -instances.support(-axes[k]) - eye;
                sceneBounds.hi[k] = instances.support(axes[k]) - eye;
            }
        }
        const std::vector<glm::dvec3> body = viewBody(camera, camera.near, camera.far, sceneBox);
        double near = camera.far, far = camera.near;
        for (const glm::dvec3& p : body) {
            near = std::min(near, glm::dot(p, camera.forward));
            far = std::max(far, glm::dot(p, camera.forward));
        }
        near = std::max(near, camera.near);
        const double pad = kernelRadius(settings_) + 1.5;
        const std::vector<double> splits = layers_ == 1 || far <= near ? std::vector<double>(size_t(layers_) + 1, far)
                                                                      : practicalSplits(near, far, layers_, std::stod(settings_.at("lambda")));
        for (int i = 0; i < layers_; ++i) {
            Cascade& c = cascades_[size_t(i)];
            c.far = splits[size_t(i) + 1];
            // Slices overlap by a thousandth, so that rounding cannot leave a pixel between two of them.
            const double sliceNear = i == 0 ? camera.near : splits[size_t(i)] * 0.999, sliceFar = i == layers_ - 1 ? camera.far : c.far * 1.001;
            c.body = layers_ == 1 ? body : viewBody(camera, sliceNear, sliceFar, sceneBox);
            c.fit = fitLight(kind_, basis_, camera, c.body, sceneBounds, size_, pad);
        }
    }

    void renderMap(int index, measure::Ledger& tally) {
        if (index == 0 && !marksReceivers()) fitCascades();
        Cascade& c = cascades_[size_t(index)];
        const gpuscene::GpuScene& scene = frame_.scene();
        if (pyramid_) pyramid_->choose({index, c.fit.clipFromRelative, frame_.camera().eye, 1e-3 * c.fit.leastW}, c.casters);
        else if (!c.culling && !c.hiz) scene.collect(frame_.camera().eye, casterTest(c), c.casters);
        glBindFramebuffer(GL_FRAMEBUFFER, c.target.name());
        glViewport(0, 0, size_, size_);
        const float one = 1;
        glClearBufferfv(GL_DEPTH, 0, &one);
        tally.texelsWritten += size_t(size_) * size_t(size_);
        glEnable(GL_DEPTH_TEST);
        glEnable(GL_DEPTH_CLAMP);  // casters in front of the receivers' range still cast
        const auto draw = [&](const gpuscene::DrawList& list) { drawCasters(scene, list, c.fit.clipFromRelative, depth_, depthAlpha_, tally); };
        if (c.culling) drawUnoccluded(index, tally);
        else if (c.hiz) c.hiz->draw({c.fit.clipFromRelative, frame_.camera().eye, 1e-3 * c.fit.leastW, c.layer}, draw);
        else draw(c.casters);
    }

    /// Casters that the sun sees before others; with a mask, before others where it is set. The receivers in sight are drawn first then.
    void drawUnoccluded(int index, measure::Ledger& tally) {
        Cascade& c = cascades_[size_t(index)];
        const glm::dvec3& eye = frame_.camera().eye;
        visibility::CullView view = visibility::CullView::sun(eye, c.fit.clipFromRelative, frame_.light());
        visibility::QueryState state{.width = size_, .height = size_, .depthClamp = true};
        std::vector<bool> drawn;
        const bool stencil = is("mask-test", "stencil");
        if (mask_) {
            const CasterTest reaches = casterTest(c);
            drawn.resize(frame_.scene().scene().instances.size());
            std::vector<uint32_t> casting, others;
            for (const uint32_t i : frame_.drawnInstances()) {
                drawn[i] = true;
                if (!castsShadow(i)) others.push_back(i);
                else if (reaches(i)) casting.push_back(i);
            }
            frame_.scene().collect(eye, casting, c.casters);
            frame_.scene().collect(eye, others, c.receivers);
            mask_->build(index, c.target, view, {c.casters, c.receivers, frame_.drawnInstances()}, depth_, depthAlpha_, tally);
            if (stencil) mask_->markStencil(index);
            else state.mask = &mask_->mask(index);
        }
        c.culling->draw(view, state, [&](const gpuscene::DrawList& list) {
            if (stencil) glDisable(GL_STENCIL_TEST);  // it is for the queries
            drawCasters(frame_.scene(), list, c.fit.clipFromRelative, depth_, depthAlpha_, tally);
            if (stencil) glEnable(GL_STENCIL_TEST);
        }, mask_ ? &drawn : nullptr);
    }

    bool castsShadow(uint32_t i) const {
        return casts_ ? casts_(i) : frame_.scene().prototypes()[frame_.scene().scene().instances[i].prototype].castsShadow;
    }

    using CasterTest = std::function<bool(uint32_t)>;
    /// Which casters can darken the part of the view that a map serves.
    CasterTest casterTest(const Cascade& c) const {
        // The kernel reaches r + ½ texels; a normal offset moves the receiver by up to (2r + 1) times its scale.
        const double r = kernelRadius(settings_);
        const double reach = r + 1.5 + (is("bias", "normal-offset") ? (2 * r + 1) * std::stod(settings_.at("bias-scale")) : 0);
        if (is("cull", "none")) return [this](uint32_t i) { return castsShadow(i); };
        return [this, cull = CasterCull(basis_, frame_.camera(), c.body, reach * std::numbers::sqrt2 * c.fit.maxTexel)](uint32_t i) {
            return castsShadow(i) && cull.keep(frame_.relativeBox(i));
        };
    }

    /// By the resolve's own look-ups, into the finest level of the pyramid or the masks.
    void markReceivers(measure::Ledger& tally) {
        gl::finishTriangles();
        fitCascades();
        if (mask_) {
            setLookup(mask_->scatterProgram());
            mask_->scatter(tally);
            return;
        }
        pyramid_->clear();
        setLookup(scatter_);
        scatter_.set("uCells", glm::vec2(pyramid_->cells(), float(pyramid_->cells()) / float(size_)));
        scatter_.use();
        frame_.bindGeometry();
        glBindImageTexture(0, pyramid_->texture().name(), 0, GL_TRUE, 0, GL_READ_WRITE, GL_R32UI);
        glDispatchCompute(GLuint(frame_.camera().width + 15) / 16, GLuint(frame_.camera().height + 7) / 8, 1);
        pyramid_->reduce();
        ++tally.drawCalls;
    }

    /// Uniforms of lib/map_lookup.glsl.
    void setLookup(const gl::Program& program) const {
        std::array<glm::mat4, 8> clips{};
        std::array<glm::vec4, 8> splits{}, texels{};
        for (size_t i = 0; i < cascades_.size(); ++i) {
            const LightFit& fit = cascades_[i].fit;
            clips[i] = glm::mat4(fit.clipFromRelative);
            // Rows u and v of an orthographic matrix are unit axes over half the window's extent.
            const auto extent = [&](int row) { return 2 / (size_ * glm::length(glm::dvec3(fit.clipFromRelative[0][row], fit.clipFromRelative[1][row], fit.clipFromRelative[2][row]))); };
            if (!fit.empty) texels[i] = {float(extent(0)), float(extent(1)), 0, 0};
            splits[i] = {float(cascades_[i].far), float(fit.depthRange * 0x1p-23), needed(cascades_[i]).empty(), 0};
        }
        frame_.setView(program);
        program.set("uBasisU", glm::vec3(basis_.u));
        program.set("uBasisV", glm::vec3(basis_.v));
        program.set("uLightClips[0]", std::span<const glm::mat4>(clips.data(), cascades_.size()));
        program.set("uSplits[0]", std::span<const glm::vec4>(splits.data(), cascades_.size()));
        program.set("uTexels[0]", std::span<const glm::vec4>(texels.data(), cascades_.size()));
        program.set("uLayers", layers_);
        program.set("uSize", float(size_));
        program.set("uBiasScale", std::stof(settings_.at("bias-scale")));
    }

    void resolve(measure::Ledger& tally) {
        glBindFramebuffer(GL_FRAMEBUFFER, frame_.visibilityTarget().name());
        glViewport(0, 0, frame_.camera().width, frame_.camera().height);
        setLookup(resolve_);
        resolve_.use();
        frame_.bindGeometry();
        glBindTextureUnit(3, map_.name());
        glBindSampler(3, sampler_.name());
        frame_.drawFullscreen();
        ++tally.drawCalls;
    }

    frame::Frame& frame_;
    Settings settings_;
    std::function<bool(uint32_t)> casts_;
    int size_, layers_;
    FitKind kind_;
    LightBasis basis_;
    gl::Texture map_;
    gl::Sampler sampler_;
    gl::Program depth_, depthAlpha_, resolve_, scatter_;
    std::optional<visibility::ReceiverPyramid> pyramid_;
    std::optional<ReceiverMask> mask_;
    std::vector<Cascade> cascades_;
};

}  // namespace

std::unique_ptr<Technique> makeMap(frame::Frame& frame, const Settings& settings, std::function<bool(uint32_t)> casts) {
    return std::make_unique<MapTechnique>(frame, settings, std::move(casts));
}

}  // namespace dapple::shadow
