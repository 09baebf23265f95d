#include "shadow/volume/silhouette_volumes.h"

#include "shadow/instanced/volume.h"
#include "shadow/map/caster_cull.h"

namespace dapple::shadow {
namespace {

/// How far volumes lie behind what they are made of, in steps of the depth buffer at a triangle's nearest point: 1e-6 of the
/// distance. A triangle that the near plane cuts is cut in the G-buffer but not here, where depth is clamped, and comes out
/// a few steps off: with 4 steps, no pixel of a cut box was wrong; with 2, hundreds were.
constexpr float kDepthSteps = 8;

}  // namespace

SilhouetteVolumes::SilhouetteVolumes(const frame::Frame& frame, const std::function<bool(const scenegen::Prototype&)>& casts, Count count, bool culls, const gl::Texture& depth)
    : frame_(frame), sums_(count == Count::sum), culls_(culls), ranges_(frame.scene().prototypes().size()) {
    const scenegen::Scene& scene = frame.scene().scene();
    Silhouettes silhouettes;
    for (const scenegen::Instance& instance : scene.instances) {
        const scenegen::Prototype& prototype = scene.prototypes[instance.prototype];
        Silhouettes::Range& range = ranges_[instance.prototype];
        if (range.faces == 0 && prototype.castsShadow && prototype.triangles() > 0 && casts(prototype)) range = silhouettes.add(prototype);
    }
    if (silhouettes.faces.empty()) return;
    corners_ = gl::Buffer::of<glm::vec4>(silhouettes.corners);
    faces_ = gl::Buffer::of<Silhouettes::Face>(silhouettes.faces);
    edges_ = gl::Buffer::of<Silhouettes::Edge>(silhouettes.edges);
    makeArray();
    const std::vector<std::string> defines = sums_ ? std::vector<std::string>{"SUM"} : std::vector<std::string>{};
    volumes_ = gl::Program("shadow/volume.vert", sums_ ? "shadow/volume_sum.frag" : "");
    count_ = gl::Program("shadow/volume.vert", "passes/count.frag");
    dark_ = gl::Program("passes/fullscreen.vert", "shadow/volume_dark.frag", defines);
    const gl::Texture* visibility[] = {&frame.visibility()};
    darkTarget_ = gl::makeFramebuffer(visibility, &depth);
    if (sums_) {
        sum_ = gl::Texture(GL_R32F, frame.camera().width, frame.camera().height);
        sampler_ = gl::makeSampler({});
    }
    const gl::Texture* sum[] = {&sum_};
    volumeTarget_ = gl::makeFramebuffer(std::span(sum, sums_ ? 1 : 0), &depth);
}

void SilhouetteVolumes::makeArray() {
    array_ = gl::makeVertexArray();
    const auto attribute = [&](GLuint index, GLint size, GLuint offset) {  // of lib/instance.glsl
        glEnableVertexArrayAttrib(array_.name(), index);
        glVertexArrayAttribFormat(array_.name(), index, size, GL_FLOAT, false, offset);
        glVertexArrayAttribBinding(array_.name(), index, 0);
    };
    attribute(3, 4, 0);
    attribute(4, 2, offsetof(gpuscene::InstanceData, cosSinYaw));
    glVertexArrayBindingDivisor(array_.name(), 0, 1);
}

void SilhouetteVolumes::count(measure::Ledger& tally) {
    glBindFramebuffer(GL_FRAMEBUFFER, volumeTarget_.name());
    glEnable(GL_DEPTH_TEST);
    glDepthMask(GL_FALSE);
    // Behind the scene is at smaller or equal depth, as z is reversed. At equal depth stands a lit surface with the cap of
    // its own volume: counted as behind, the cap cancels what lies farther back, and the surface is lit.
    glEnable(GL_POLYGON_OFFSET_FILL);
    glPolygonOffset(0, -kDepthSteps);
    if (sums_) {
        const float zero[4] = {0, 0, 0, 0};
        glClearBufferfv(GL_COLOR, 0, zero);
        glDepthFunc(GL_LEQUAL);
        glEnable(GL_BLEND);
        glBlendFunc(GL_ONE, GL_ONE);
    } else {
        glDepthFunc(GL_GREATER);
        glEnable(GL_STENCIL_TEST);
        glStencilOpSeparate(GL_FRONT, GL_KEEP, GL_DECR_WRAP, GL_KEEP);
        glStencilOpSeparate(GL_BACK, GL_KEEP, GL_INCR_WRAP, GL_KEEP);
    }
    submit(volumes_, tally);
}

void SilhouetteVolumes::submit(const gl::Program& program, measure::Ledger& tally) {
    const gpuscene::GpuScene& scene = frame_.scene();
    const frame::Camera& camera = frame_.camera();
    const base::DBox sceneBox = frame_.relativeSceneBox();
    const Extrusion extrusion = extrusionFor(sceneBox, frame_.light());
    const CasterCull cull(lightBasis(frame_.light(), camera.forward), camera, viewBody(camera, camera.near, camera.far, sceneBox),
                          1e-3 * glm::length(sceneBox.size()));
    const auto keep = [&](uint32_t i) {
        return ranges_[scene.scene().instances[i].prototype].faces > 0 && (!culls_ || cull.keep(frame_.relativeBox(i)));
    };
    scene.collect(camera.eye, keep, casters_);
    glViewport(0, 0, camera.width, camera.height);
    glEnable(GL_DEPTH_CLAMP);
    frame_.setView(program);
    program.set("uExtrusion", float(extrusion.most));
    program.set("uFloor", float(extrusion.floor));
    program.use();
    const gl::Buffer* buffers[] = {&corners_, &faces_, &edges_};
    for (GLuint i = 0; i < 3; ++i) glBindBufferBase(GL_SHADER_STORAGE_BUFFER, i, buffers[i]->name());
    glBindVertexArray(array_.name());
    glVertexArrayVertexBuffer(array_.name(), 0, casters_.buffer.name(), 0, sizeof(gpuscene::InstanceData));
    for (const gpuscene::DrawList::Range& drawn : casters_.ranges) {
        const Silhouettes::Range& range = ranges_[drawn.part];
        program.set("uFirstFace", int(range.firstFace));
        program.set("uFaces", int(range.faces));
        program.set("uFirstEdge", int(range.firstEdge()));
        program.set("uTop", scene.prototypes()[drawn.part].box.hi.z);
        const size_t triangles = range.faces + 2 * range.edges();
        glDrawArraysInstancedBaseInstance(GL_TRIANGLES, 0, GLsizei(3 * triangles), GLsizei(drawn.count), drawn.first);
        ++tally.drawCalls;
        tally.trianglesSubmitted += triangles * drawn.count;
    }
}

void SilhouetteVolumes::darken(measure::Ledger& tally) const {
    glBindFramebuffer(GL_FRAMEBUFFER, darkTarget_.name());
    glViewport(0, 0, frame_.camera().width, frame_.camera().height);
    glColorMask(GL_TRUE, GL_FALSE, GL_FALSE, GL_FALSE);  // validity stays
    // The triangle lies at depth 0, before which every surface is, but not the sky.
    glEnable(GL_DEPTH_TEST);
    glDepthMask(GL_FALSE);
    if (sums_) {
        glBindTextureUnit(3, sum_.name());
        glBindSampler(3, sampler_.name());
    } else {
        glEnable(GL_STENCIL_TEST);
        glStencilFunc(GL_NOTEQUAL, 0, 0xFF);
    }
    dark_.use();
    frame_.drawFullscreen();
    ++tally.drawCalls;
}

void SilhouetteVolumes::addOverdraw() {
    measure::Ledger ignored;
    if (!empty()) submit(count_, ignored);
}

}  // namespace dapple::shadow
