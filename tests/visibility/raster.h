#pragma once

#include "gl/program.h"
#include "gpuscene/gpu_scene.h"
#include "visibility/views.h"

#include <algorithm>
#include <vector>

namespace dapple::visibility {

/// A depth target and its scene.
class Raster {
public:
    Raster(const gpuscene::GpuScene& scene, int width, int height)
        : scene_(scene), depth_(GL_DEPTH_COMPONENT32F, width, height), target_(gl::makeFramebuffer({}, &depth_)),
          opaque_("shadow/map_depth.vert", ""), alpha_("shadow/map_depth.vert", "shadow/map_depth.frag", {"ALPHA_TEST"}) {}

    /// An empty frame: reversed z for a camera, depth clamp for a sun.
    void start(const CullView& view) {
        view_ = view;
        gl::resetState();
        glBindFramebuffer(GL_FRAMEBUFFER, target_.name());
        glViewport(0, 0, depth_.width(), depth_.height());
        const float farthest = view.parallel ? 1 : 0;
        glClearBufferfv(GL_DEPTH, 0, &farthest);
        glEnable(GL_DEPTH_TEST);
        glDepthFunc(view.parallel ? GL_LESS : GL_GREATER);
        if (view.parallel) glEnable(GL_DEPTH_CLAMP);
    }
    void submit(const gpuscene::DrawList& list) {
        for (const gl::Program* program : {&opaque_, &alpha_}) {
            const bool solid = program == &opaque_;
            program->set("uLightClip", glm::mat4(view_.clipFromRelative));
            program->use();
            scene_.draw(list, solid ? gpuscene::Bucket::opaque : gpuscene::Bucket::alphaTested,
                        solid ? gpuscene::Attributes::position : gpuscene::Attributes::positionUv, program->name());
        }
    }
    void submit(const std::function<bool(uint32_t)>& keep) {
        scene_.collect(view_.eye, keep, list_);
        submit(list_);
    }
    std::vector<float> everything() {
        submit([](uint32_t) { return true; });
        return read();
    }
    std::vector<float> read() const {
        std::vector<float> texels(size_t(depth_.width()) * size_t(depth_.height()));
        glGetTextureImage(depth_.name(), 0, GL_DEPTH_COMPONENT, GL_FLOAT, GLsizei(texels.size() * sizeof(float)), texels.data());
        return texels;
    }
    const gl::Texture& depth() const { return depth_; }
    const CullView& view() const { return view_; }

private:
    const gpuscene::GpuScene& scene_;
    gl::Texture depth_;
    gl::Framebuffer target_;
    gl::Program opaque_, alpha_;
    gpuscene::DrawList list_;
    CullView view_;
};

inline CullView cameraAt(const glm::dvec3& eye, const glm::dvec3& forward) { return CullView::camera(eye, cameraMatrix(forward, 0.8, 0.6, 0.3, 300), 0.3); }
inline CullView sunAt(const glm::dvec3& eye, const glm::dvec3& direction, double half, double warp = 0) {
    const glm::dvec3 l = glm::normalize(direction);
    return CullView::sun(eye, sunMatrix(l, half, -20, 60, warp), l);  // what stands before z = −20 relies on depth clamp
}

inline size_t different(const std::vector<float>& a, const std::vector<float>& b) {
    size_t count = 0;
    for (size_t i = 0; i < a.size(); ++i) count += a[i] != b[i];
    return count;
}

}  // namespace dapple::visibility
