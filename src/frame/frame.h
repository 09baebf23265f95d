#pragma once

#include "frame/camera.h"
#include "frame/pass.h"
#include "gl/program.h"
#include "gpuscene/gpu_scene.h"
#include "truth/reference.h"

#include <functional>
#include <memory>
#include <vector>

namespace dapple::frame {

/// Name of what belongs to one sun, a pass or a resource: the first sun's as it is, "map.2" for the second's "map".
std::string ofSun(const std::string& name, size_t sun);

/// One view of one scene at one resolution: what every technique gets (G-buffer, scene, sun) and the one
/// image that it gives for a sun (visibility). Techniques that are compared share a Frame; each frame of each redoes it all.
class Frame {
public:
    Frame(const gpuscene::GpuScene& scene, const scenegen::View& view, int width, int height);

    /// Moves the camera; resolution and targets stay.
    void look(const scenegen::View& view) {
        camera_ = Camera(view, camera_.width, camera_.height);
        everything_.data.clear();  // its positions are relative to the eye that was
    }

    /// Looks through points beside the pixels' centres from the next G-buffer on (Camera::shiftBy). Techniques do not know of it.
    void shiftBy(const glm::dvec2& pixels) { camera_.shiftBy(pixels); }

    /// Moves the first sun. Techniques follow in the next frame; a Renderer's passes may change with replan().
    void setSun(const scenegen::Sun& sun) {
        suns_[0].sun = sun;
        suns_[0].light = sun.direction();
    }
    /// Of the scene: the first, then the further ones.
    size_t suns() const { return suns_.size(); }
    /// To be called when instances have moved (gpuscene::GpuScene::instancesMoved).
    void instancesMoved() { everything_.data.clear(); }

    const gpuscene::GpuScene& scene() const { return *scene_; }
    const Camera& camera() const { return camera_; }
    const scenegen::Sun& sun() const { return suns_[current_].sun; }
    const glm::dvec3& light() const { return suns_[current_].light; }  ///< unit, direction in which the light travels
    bool sunUp() const { return light().z < 0; }
    /// A box, that of an instance, or of the whole scene, relative to the eye.
    base::DBox relative(const base::Box& box) const;
    base::DBox relativeBox(uint32_t instance) const { return relative(scene_->instanceBoxes()[instance]); }
    base::DBox relativeSceneBox() const { return relative(scene_->box()); }

    // Targets. Rows from the bottom, as GL has them.
    const gl::Texture& surface() const { return surface_; }      ///< RGBA32UI, see lib/gbuffer.glsl
    const gl::Texture& depth() const { return depth_; }          ///< D32F, reversed; 0 = sky
    const gl::Texture& visibility() const { return suns_[current_].visibility; }///< RG16F: V (0 dark … 1 lit), validity
    const gl::Texture& shaded() const { return shaded_; }        ///< sRGB
    const gl::Framebuffer& visibilityTarget() const { return suns_[current_].target; }
    const gl::Framebuffer& shadedTarget() const { return shadedTarget_; }

    /// Sets the uniforms of lib/view.glsl, and uLight to the current sun's.
    void setView(const gl::Program& program) const;
    /// Binds surface to unit 1 and depth to unit 2, as the resolves of all techniques expect them.
    void bindGeometry() const;
    /// Draws the triangle that covers the screen.
    void drawFullscreen() const;

    /// Draws what the camera sees; decides what that is.
    using Culling = std::function<void(const gpuscene::Submit&)>;
    /// Without a culling: the instances whose boxes meet the view frustum.
    Pass gbufferPass(Culling culling = {}, bool asksOcclusion = false);
    /// Items, of whatever Items the culling has, that the last G-buffer pass drew; empty where the GPU chose them.
    const std::vector<uint32_t>& drawnItems() const { return drawn_; }
    Pass shadePass(bool shadowed);  ///< of all suns
    Pass barePass();  ///< everything, nothing culled, forward, straight to `shaded`

    /// Additive count of the fragments that `barePass` or the G-buffer pass shades, into `overdraw()`.
    void countGeometry();
    const gl::Texture& overdraw();  ///< R32F, made on first use
    gl::Framebuffer& overdrawTarget();

    // Read-backs, rows from the top. They block.
    truth::Receivers readReceivers() const;
    std::vector<float> readVisibility() const;
    std::vector<uint8_t> readValidity() const;
    base::Image8 readShaded() const;
    base::ImageF readChannel(const gl::Texture& texture, int layer = 0) const;  ///< first channel or depth

private:
    friend class OfSun;
    struct Programs;
    void setGeometryState() const;
    void setView(const Programs& programs) const;
    void collectInView();
    void drawGeometry(const gpuscene::DrawList& list, const Programs& programs, measure::Ledger& tally,
                      gpuscene::Faces faces = gpuscene::Faces::front);

    const gpuscene::GpuScene* scene_;
    Camera camera_;
    struct SunLight {
        scenegen::Sun sun;
        glm::dvec3 light;
        gl::Texture visibility;
        gl::Framebuffer target;
    };
    std::string sunsDefine() const;
    void setSuns(const gl::Program& program) const;  ///< uniforms of lib/shading.glsl

    std::vector<SunLight> suns_;
    size_t current_ = 0;
    gl::Texture surface_, depth_, shaded_, overdraw_;
    gl::Framebuffer gbufferTarget_, shadedTarget_, bareTarget_, overdrawTarget_, countTarget_;
    gl::VertexArray noAttributes_;
    gl::Sampler nearest_;
    gpuscene::DrawList visible_, everything_;
    std::vector<uint32_t> drawn_;
    std::shared_ptr<const Programs> gbuffer_, bare_, count_;
    gl::Program shade_, shadeUnshadowed_;
};

/// Whose light and whose visibility image a frame means, as long as this lives: else the first sun's.
class OfSun {
public:
    OfSun(Frame& frame, size_t sun) : frame_(frame) { frame_.current_ = sun; }
    ~OfSun() { frame_.current_ = 0; }
    OfSun(const OfSun&) = delete;
    OfSun& operator=(const OfSun&) = delete;

private:
    Frame& frame_;
};

}  // namespace dapple::frame
