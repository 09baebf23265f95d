#include "frame/lamps.h"

#include <algorithm>
#include <cmath>

namespace dapple::frame {
namespace {

/// Lamp of lib/lamp.glsl.
struct GpuLamp {
    glm::vec4 position, direction, intensity;
};

}  // namespace

Lamps::Lamps(Frame& frame) : frame_(frame) {
    if (frame.scene().facts().lights == 0) return;
    program_ = gl::Program("passes/lamp.vert", "passes/lamp.frag");
    noAttributes_ = gl::makeVertexArray();
}

Pass Lamps::pass() {
    return {"lamps", {"gbuffer", "depth", "shaded"}, {"shaded"}, "light of the local lights in view, unshadowed",
            program_.name() ? "" : "the scene has no local light", [this](measure::Ledger& tally) { draw(tally); }};
}

void Lamps::draw(measure::Ledger& tally) {
    const Camera& camera = frame_.camera();
    const auto planes = camera.planes();
    std::vector<GpuLamp> lamps;
    for (const scenegen::LocalLight& light : frame_.scene().scene().lights) {
        const glm::dvec3 p = glm::dvec3(light.position) - camera.eye;
        if (std::any_of(planes.begin(), planes.end(), [&](const glm::dvec4& plane) { return glm::dot(glm::dvec3(plane), p) + plane.w < -double(light.range); })) continue;
        const float inner = std::cos(light.innerAngle), outer = std::cos(light.outerAngle);
        // A lamp without a shade shines alike to all sides: its cone is whole everywhere.
        const bool shade = light.outerAngle < 3.14159f;
        lamps.push_back({{p, light.range}, {light.direction, shade ? outer : -2.0f}, {light.intensity, shade ? 1 / std::max(inner - outer, 1e-4f) : 1.0f}});
    }
    if (lamps.empty()) return;
    buffer_.update(lamps.size() * sizeof(GpuLamp), lamps.data());
    glBindFramebuffer(GL_FRAMEBUFFER, frame_.shadedTarget().name());
    glViewport(0, 0, camera.width, camera.height);
    glEnable(GL_FRAMEBUFFER_SRGB);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE);
    glEnable(GL_CULL_FACE);
    glCullFace(GL_FRONT);
    glEnable(GL_DEPTH_CLAMP);  // a cube may reach beyond the far plane
    frame_.setView(program_);
    program_.use();
    frame_.bindGeometry();
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, buffer_.name());
    glBindVertexArray(noAttributes_.name());
    glDrawArraysInstanced(GL_TRIANGLES, 0, 36, GLsizei(lamps.size()));
    ++tally.drawCalls;
    tally.trianglesSubmitted += 12 * lamps.size();
}

}  // namespace dapple::frame
