#pragma once

#include "gpuscene/instance_table.h"
#include "visibility/max_pyramid.h"

#include <optional>

namespace dapple::visibility {

/// Two-phase occlusion culling on the GPU against a hierarchy of depths (Greene, Kass, Miller 1993, "Hierarchical Z-Buffer
/// Visibility"; two phases after Aaltonen and Haar 2015, "GPU-Driven Rendering Pipelines"): what was visible in the last frame
/// is drawn, then what the depth so drawn does not hide. Indirect draws, nothing is read back, nothing waits.
/// One object a view; the first frame, and one after a cut, draws little in its first phase, and is right all the same.
class HizCulling {
public:
    /// `reversed`: depth 1 is near, and tested with GL_GREATER. `castersOnly`: leave out what casts no shadow.
    HizCulling(const gpuscene::GpuScene& scene, bool castersOnly, bool reversed);

    struct View {
        glm::dmat4 clipFromRelative{1};
        glm::dvec3 eye{0};    ///< metres from Scene::origin
        double leastW = 0.5;  ///< clip w up to which nothing is known of a box
        const gl::Texture& depth;  ///< 2D, that is drawn into and cleared
    };
    void draw(const View& view, const gpuscene::Submit& submit);
    /// Drawn by the last draw(). Waits for the GPU.
    gpuscene::InstanceTable::Drawn drawn() const;

private:
    void choose(const gl::Program& program, const View& view, gpuscene::DrawList& list);

    const gpuscene::InstanceTable& table_;
    bool castersOnly_, reversed_;
    MaxPyramid farthest_;
    gl::Buffer visible_;  // by instance
    gl::Program first_, second_, cells_;
    gl::Sampler nearest_;
    gpuscene::DrawList lists_[2];  // by phase
};

}  // namespace dapple::visibility
