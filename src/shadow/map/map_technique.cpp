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
#include <set>

namespace dapple::shadow {
namespace {

using gpuscene::Attributes;
using gpuscene::Bucket;

class MapTechnique final : public Technique {
public:
    MapTechnique(frame::Frame& frame, const Settings& settings, const std::function<bool(uint32_t)>& casts)
        : frame_(frame), settings_(settings), items_(cullItems(frame.scene(), settings)), size_(std::stoi(settings.at("size"))), layers_(std::stoi(settings.at("cascades"))),
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
            pyramid_.emplace(size_, layers_, int(2 * kernelRadius(settings)));
            defines.push_back(fmt::format("MARKED_LEVELS {}", pyramid_->markedLevels()));
            scatter_ = gl::Program::compute("shadow/map_receivers.comp", defines);
            defines.pop_back();
        }
        for (int i = 0; i < layers_; ++i) {
            Cascade& c = cascades_[size_t(i)];
            c.layer = map_.view(i);
            if (pyramid_) c.culling = std::make_unique<visibility::PyramidCulling>(items_, *pyramid_, i);
            else if (casts) c.culling = std::make_unique<visibility::ListCulling>(items_, true, casts);
            else c.culling = makeCulling(frame.scene(), settings, settings.at("cull"), true, {size_, size_});
        }
        if (is("cull", "receivers")) mask_.emplace(frame, items_, settings, map_, defines);
    }

    std::vector<frame::Pass> passes() override {
        fitCascades(false);  // a slice of the view that nothing can be in has nothing in sight either
        std::vector<frame::Pass> passes;
        std::vector<std::string> reads{"gbuffer", "depth"}, mapReads;
        if (mask_) mapReads = reads;
        if (marksReceivers()) {
            const bool some = std::any_of(cascades_.begin(), cascades_.end(), [&](const Cascade& c) { return needed(c).empty(); });
            passes.push_back({"receivers", reads, {"receivers"}, "where the look-ups of the visible receivers fall in the maps, and how far from the sun",
                              some ? "" : needed(cascades_[0]), [this](measure::Ledger& tally) { markReceivers(tally); }});
            mapReads.push_back("receivers");
        }
        const bool asksOcclusion = cascades_[0].culling && cascades_[0].culling->statistics();
        for (int i = 0; i < layers_; ++i) {
            const std::string name = mapName(i);
            const std::string leftOut = needed(cascades_[size_t(i)]);
            passes.push_back({name, mapReads, {name}, "depth of the casters seen from the sun", leftOut,
                              [this, i](measure::Ledger& tally) { renderMap(i, tally); }, asksOcclusion});
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
            if (!cascades_[i].fit.empty) result.push_back({fmt::format("map{}", i), cascades_[i].fit.clipFromRelative, sliceOf(i)});
        return result;
    }

    bool redrawCasters(size_t matrix, const gpuscene::Submit& submit) override {
        gpuscene::DrawList list;
        items_.collect(frame_.camera().eye, itemsDrawn(cascades_[mapOf(matrix)]), list);
        submit(list);
        return true;
    }
    std::optional<base::ImageF> receiverMask(size_t matrix) const override {
        const int map = int(mapOf(matrix));
        if (pyramid_) return pyramid_->mask(map);
        if (mask_) return frame_.readChannel(mask_->mask(map));
        return std::nullopt;
    }

    std::optional<Casters> castersDrawn() const override {
        Casters sum;
        for (const Cascade& c : cascades_) {
            if (!needed(c).empty()) continue;
            std::set<uint32_t> instances;  // an instance may have been drawn in clusters
            for (const uint32_t i : itemsDrawn(c)) {
                instances.insert(items_[i].instance);
                sum.triangles += items_.part(i).triangles;
            }
            sum.instances += instances.size();
        }
        return sum;
    }

    std::vector<std::pair<std::string, visibility::Statistics>> queryStatistics() const override {
        std::vector<std::pair<std::string, visibility::Statistics>> result;
        for (int i = 0; i < layers_; ++i) {
            const Cascade& c = cascades_[size_t(i)];
            const auto statistics = c.culling && needed(c).empty() ? c.culling->statistics() : std::nullopt;
            if (statistics) result.emplace_back(mapName(i), *statistics);
        }
        return result;
    }

    const gl::Texture* map() const override { return map_.name() ? &map_ : nullptr; }

private:
    struct Cascade {
        LightFit fit;
        std::vector<glm::dvec3> body;
        double far = 0;  // metres of eye depth where the next cascade begins
        gl::Framebuffer target;
        gl::Texture layer;  // of the map
        std::unique_ptr<visibility::Culling> culling;
        gpuscene::DrawList receivers, others;  // with a mask: those in sight, that cast and that do not
    };

    /// None into a map that is left out.
    std::vector<uint32_t> itemsDrawn(const Cascade& c) const {
        if (!needed(c).empty()) return {};
        std::vector<uint32_t> items = c.culling->drawn();
        items.insert(items.end(), c.receivers.items.begin(), c.receivers.items.end());  // with a mask: drawn before
        return items;
    }

    /// As map_lookup.glsl divides the view.
    LightMatrix::Slice sliceOf(size_t i) const {
        const Cascade& c = cascades_[i];
        const bool warped = kind_ == FitKind::lispsm;
        return {int(i), i == 0 ? 0 : cascades_[i - 1].far, i + 1 == cascades_.size() ? frame_.camera().far : c.far, depthStep(c),
                warped ? std::nullopt : std::optional(texelExtent(c)), basis_.u, basis_.v, needed(c).empty()};
    }
    static double depthStep(const Cascade& c) { return c.fit.depthRange * 0x1p-23; }
    /// Metres along u and v: these rows of an orthographic matrix are unit axes over half the window's extent.
    glm::dvec2 texelExtent(const Cascade& c) const {
        const glm::dmat4& m = c.fit.clipFromRelative;
        const auto extent = [&](int row) { return 2 / (size_ * glm::length(glm::dvec3(m[0][row], m[1][row], m[2][row]))); };
        return {extent(0), extent(1)};
    }

    /// Of matrices()[matrix]: maps that nothing needs have none.
    size_t mapOf(size_t matrix) const {
        size_t map = 0;
        while (cascades_[map].fit.empty || matrix-- > 0) ++map;
        return map;
    }

    bool is(const char* axisName, const char* value) const { return settings_.at(axisName) == value; }
    std::string mapName(int layer) const { return layers_ == 1 ? "map" : fmt::format("map{}", layer); }
    /// Whether a pass of its own finds where look-ups fall, before any map.
    bool marksReceivers() const { return pyramid_ || (mask_ && mask_->scatters()); }

    /// Why a cascade's map is not needed; empty when it is.
    std::string needed(const Cascade& cascade) const {
        if (!frame_.scene().facts().casters) return "the scene has no caster";
        if (cascade.fit.empty) return "no receiver can lie in this slice of the view";
        return {};
    }

    /// Cheap enough to be redone in every frame, as a moving camera would have to.
    void fitCascades(bool drawn = true) {
        const frame::Camera& camera = frame_.camera();
        basis_ = lightBasis(frame_.light(), camera.forward);
        const base::DBox sceneBox = frame_.relativeSceneBox();
        base::DBox sceneBounds;
        if (kind_ == FitKind::scene) {  // tighter than the box of everything, which the sun sees askew
            const gpuscene::Hierarchy& instances = frame_.scene().hierarchy(gpuscene::Items::kLeafTriangles, false);
            const glm::dvec3 axes[] = {basis_.u, basis_.v, basis_.l};
            for (int k = 0; k < 3; ++k) {
                const double eye = glm::dot(camera.eye, axes[k]);
                sceneBounds.lo[k] = -instances.support(-axes[k]) - eye;
                sceneBounds.hi[k] = instances.support(axes[k]) - eye;
            }
        }
        std::vector<base::DBox> boxes;
        const bool visible = drawn && is("focus", "visible");
        if (visible)
            for (const uint32_t i : frame_.drawnItems()) boxes.push_back(frame_.relative(items_.boxes()[i]));
        const auto bodyOf = [&](double from, double to) { return visible ? visibleBody(camera, from, to, boxes) : viewBody(camera, from, to, sceneBox); };
        const std::vector<glm::dvec3> body = bodyOf(camera.near, camera.far);
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
            c.body = layers_ == 1 ? body : bodyOf(sliceNear, sliceFar);
            c.fit = fitLight(kind_, basis_, camera, c.body, sceneBounds, size_, pad);
        }
    }

    void renderMap(int index, measure::Ledger& tally) {
        if (index == 0 && !marksReceivers()) fitCascades();
        Cascade& c = cascades_[size_t(index)];
        if (c.fit.empty) return;  // nothing is in sight in its slice
        const frame::Camera& camera = frame_.camera();
        glBindFramebuffer(GL_FRAMEBUFFER, c.target.name());
        glViewport(0, 0, size_, size_);
        const float one = 1;
        glClearBufferfv(GL_DEPTH, 0, &one);
        tally.texelsWritten += size_t(size_) * size_t(size_);
        glEnable(GL_DEPTH_TEST);
        glEnable(GL_DEPTH_CLAMP);  // casters in front of the receivers' range still cast
        visibility::ViewFrame frame{.view = visibility::CullView::sun(camera.eye, c.fit.clipFromRelative, frame_.light()),
                                    .leastW = 1e-3 * c.fit.leastW, .depth = &c.layer, .depthClamp = true};
        const CasterCull reaches = casterCull(c);
        if (is("cull", "none") || is("cull", "frustum")) frame.view.planes.clear();  // the receivers' alone
        if (is("cull", "frustum") || pyramid_ || mask_) reaches.appendPlanes(frame.view.planes);
        setCasterClip(c.fit.clipFromRelative, depth_, depthAlpha_);
        if (mask_) drawReceivers(index, reaches, frame, tally);
        const bool stencil = mask_ && is("mask-test", "stencil");
        c.culling->draw(frame, [&](const gpuscene::DrawList& list) {
            if (stencil) glDisable(GL_STENCIL_TEST);  // it is for the queries
            drawCasters(frame_.scene(), list, depth_, depthAlpha_, tally);
            countMapFragments(frame_.scene(), list, depth_, depthAlpha_, tally);
            if (stencil) glEnable(GL_STENCIL_TEST);
        });
        countMapTexels(map_, index, 0, 0, size_, tally);
    }

    /// Of those in sight. The queries for all other casters then count only where the mask that they make is set.
    void drawReceivers(int index, const CasterCull& reaches, visibility::ViewFrame& frame, measure::Ledger& tally) {
        Cascade& c = cascades_[size_t(index)];
        std::vector<uint32_t> casting, others;
        frame.drawn = frame_.drawnItems();
        if (frame.drawn.empty()) frame.view.planes.assign(1, {0, 0, 0, -1e300});  // no receiver: no caster is needed
        for (const uint32_t i : frame.drawn)
            if (!items_.part(i).castsShadow) others.push_back(i);
            else if (reaches.keep(frame.view.relative(items_.boxes()[i]))) casting.push_back(i);
        items_.collect(frame.view.eye, casting, c.receivers);
        items_.collect(frame.view.eye, others, c.others);
        mask_->build(index, c.target, frame.view, {c.receivers, c.others, frame.drawn}, depth_, depthAlpha_, tally);
        countMapFragments(frame_.scene(), c.receivers, depth_, depthAlpha_, tally);
        if (is("mask-test", "stencil")) mask_->markStencil(index);
        else frame.mask = &mask_->mask(index);
    }

    /// What can darken the part of the view that a map serves.
    CasterCull casterCull(const Cascade& c) const {
        // The kernel reaches r + ½ texels; a normal offset moves the receiver by up to (2r + 1) times its scale.
        const double r = kernelRadius(settings_);
        const double reach = r + 1.5 + (is("bias", "normal-offset") ? (2 * r + 1) * std::stod(settings_.at("bias-scale")) : 0);
        return CasterCull(basis_, frame_.camera(), c.body, reach * std::numbers::sqrt2 * c.fit.maxTexel);
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
        pyramid_->setMarking(scatter_);
        glDispatchCompute(GLuint(frame_.camera().width + 15) / 16, GLuint(frame_.camera().height + 7) / 8, 1);
        pyramid_->reduce();
        ++tally.drawCalls;
    }

    /// Uniforms of lib/map_lookup.glsl.
    void setLookup(const gl::Program& program) const {
        std::array<glm::mat4, 8> clips{};
        std::array<glm::vec4, 8> splits{}, texels{};
        const base::DBox box = frame_.relativeSceneBox();
        const auto farthest = float(box.empty() ? 0 : glm::length(glm::max(glm::abs(box.lo), glm::abs(box.hi))));
        for (size_t i = 0; i < cascades_.size(); ++i) {
            const LightFit& fit = cascades_[i].fit;
            clips[i] = glm::mat4(fit.clipFromRelative);
            if (!fit.empty) texels[i] = glm::vec4(texelExtent(cascades_[i]), 0, 0);
            splits[i] = {float(cascades_[i].far), float(depthStep(cascades_[i])), needed(cascades_[i]).empty(), farthest};
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
    const gpuscene::Items& items_;
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

std::unique_ptr<Technique> makeMap(frame::Frame& frame, const Settings& settings, const std::function<bool(uint32_t)>& casts) {
    return std::make_unique<MapTechnique>(frame, settings, casts);
}

}  // namespace dapple::shadow
