#include "bench/light_picture.h"

#include "base/error.h"
#include "frame/overlays.h"
#include "shadow/families.h"

#include <algorithm>

namespace dapple::bench {
namespace {

constexpr int kPixels = 1024;  // along a side of a light's view

/// Casters in one light's window, each pixel with the class of what is nearest to the sun.
class LightCamera {
public:
    explicit LightCamera(const SharedFrame& shared)
        : shared_(shared), classes_(GL_R32F, kPixels, kPixels), depth_(GL_DEPTH_COMPONENT32F, kPixels, kPixels),
          opaque_("shadow/map_depth.vert", "shadow/caster_class.frag") {
        if (shared.loaded->gpu.has(gpuscene::Bucket::alphaTested)) alpha_ = gl::Program("shadow/map_depth.vert", "shadow/caster_class.frag", {"ALPHA_TEST"});
        const gl::Texture* colours[] = {&classes_};
        target_ = gl::makeFramebuffer(colours, &depth_);
    }

    void begin(const glm::dmat4& clip) {
        gl::resetState();
        glBindFramebuffer(GL_FRAMEBUFFER, target_.name());
        glViewport(0, 0, kPixels, kPixels);
        const float zero[4] = {0, 0, 0, 0}, one = 1;
        glClearBufferfv(GL_COLOR, 0, zero);
        glClearBufferfv(GL_DEPTH, 0, &one);
        glEnable(GL_DEPTH_TEST);
        glDepthFunc(GL_LEQUAL);  // what was drawn already, again in another class
        glEnable(GL_DEPTH_CLAMP);
        shadow::setCasterClip(clip, opaque_, alpha_);
    }
    gpuscene::Submit submit(frame::LightViewClass kind) {
        for (const gl::Program* program : {&opaque_, &alpha_})
            if (program->name()) program->set("uClass", float(kind));
        return [this](const gpuscene::DrawList& list) {
            measure::Ledger ignored;
            shadow::drawCasters(shared_.loaded->gpu, list, opaque_, alpha_, ignored);
        };
    }
    frame::LightView end() {
        gl::resetState();
        const base::ImageF kinds = shared_.frame.readChannel(classes_);
        frame::LightView view{shared_.frame.readChannel(depth_), {}};
        for (const float kind : kinds.texels) view.classes.push_back(frame::LightViewClass(int(kind)));
        return view;
    }

private:
    const SharedFrame& shared_;
    gl::Texture classes_, depth_;
    gl::Framebuffer target_;
    gl::Program opaque_, alpha_;
};

void addReceivers(const truth::Receivers& seen, const glm::dmat4& clip, frame::LightView& view) {
    for (size_t i = 0; i < seen.present.size(); ++i) {
        const glm::dvec4 q = clip * glm::dvec4(seen.position[i], 1);
        if (!seen.present[i] || !(q.w > 0)) continue;
        const double x = std::floor((q.x / q.w + 1) / 2 * kPixels), y = std::floor((1 - q.y / q.w) / 2 * kPixels);
        if (!(x >= 0 && y >= 0 && x < kPixels && y < kPixels)) continue;
        frame::LightViewClass& kind = view.classes[size_t(y) * kPixels + size_t(x)];
        if (kind == frame::LightViewClass::nothing) kind = frame::LightViewClass::receiver;
    }
}

}  // namespace

base::Image8 paintCastersDrawn(SharedFrame& shared, shadow::Renderer& renderer) {
    const auto none = [] { return base::UsageError("the technique draws no casters into a map of the scene"); };
    if (!renderer.technique() || renderer.technique()->matrices().empty()) throw none();
    const std::vector<shadow::LightMatrix> matrices = renderer.technique()->matrices();
    const gpuscene::Items& items = shared.loaded->gpu.items();
    const glm::dvec3 eye = shared.frame.camera().eye;
    std::vector<uint32_t> casters;
    for (uint32_t i = 0; i < items.size(); ++i)
        if (items.part(i).castsShadow) casters.push_back(i);
    gpuscene::DrawList all, contributing;
    items.collect(eye, casters, all);
    LightCamera camera(shared);
    std::vector<frame::LightView> views;
    for (size_t m = 0; m < matrices.size(); ++m) {
        camera.begin(matrices[m].clipFromRelative);
        camera.submit(frame::LightViewClass::leftOut)(all);
        if (!renderer.redrawCasters(m, camera.submit(frame::LightViewClass::drawn))) throw none();
        views.push_back(camera.end());
    }
    // Last, because tracing renders a G-buffer of its own.
    items.collect(eye, shared.contributors(), contributing);
    const truth::Receivers seen = shared.receivers();
    for (size_t m = 0; m < matrices.size(); ++m) {
        camera.begin(matrices[m].clipFromRelative);
        camera.submit(frame::LightViewClass::leftOut)(all);
        camera.submit(frame::LightViewClass::contributing)(contributing);
        const frame::LightView alone = camera.end();
        for (size_t i = 0; i < alone.classes.size(); ++i)
            if (alone.classes[i] == frame::LightViewClass::contributing && views[m].classes[i] == frame::LightViewClass::drawn)
                views[m].classes[i] = frame::LightViewClass::contributing;
        addReceivers(seen, matrices[m].clipFromRelative, views[m]);
    }
    return frame::paintLightViews(views);
}

base::Image8 paintReceiverMasks(const SharedFrame& shared, const shadow::Renderer& renderer) {
    std::vector<base::ImageF> maps, masks;
    const shadow::Technique* technique = renderer.technique();
    if (technique && !technique->map()) throw base::UsageError("no map is drawn here, so that none has a mask");
    for (size_t m = 0; technique && m < technique->matrices().size(); ++m) {
        std::optional<base::ImageF> mask = technique->receiverMask(m);
        if (!mask) break;
        masks.push_back(std::move(*mask));
        maps.push_back(shared.frame.readChannel(*technique->map(), int(m)));
    }
    if (masks.empty()) throw base::UsageError("only the maps of cull receivers and cull pyramid have masks");
    return frame::paintMasks(maps, masks);
}

}  // namespace dapple::bench
