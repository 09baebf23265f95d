#pragma once

#include "frame/frame.h"
#include "shadow/volume/silhouette.h"

#include <functional>

namespace dapple::shadow {

/// Shadow volumes of closed casters, extruded from their silhouettes on the GPU and counted behind the scene.
class SilhouetteVolumes {
public:
    /// What the volumes about a pixel are counted in: 8 bits that wrap, or floats.
    enum class Count { stencil, sum };
    /// `casts`: which prototypes; each must be closed, else UsageError. `depth`: the scene's, with stencil bits that are 0 when
    /// record() begins if they are what is counted in. `culls`: leaves out what cannot reach the view.
    SilhouetteVolumes(const frame::Frame& frame, const std::function<bool(const scenegen::Prototype&)>& casts, Count count, bool culls, const gl::Texture& depth);
    /// No instance casts.
    bool empty() const { return !faces_.name(); }
    void count(measure::Ledger& tally);
    /// Darkens the visibility image where a volume holds the pixel.
    void darken(measure::Ledger& tally) const;
    /// Adds 1 for every fragment, those before the scene too: each is tested. The target and its blending are the caller's.
    void addOverdraw();

private:
    void makeArray();
    void submit(const gl::Program& program, measure::Ledger& tally);

    const frame::Frame& frame_;
    bool sums_, culls_;
    std::vector<Silhouettes::Range> ranges_;  ///< by prototype; without faces where it casts nothing
    gl::Buffer corners_, faces_, edges_;
    gpuscene::DrawList casters_;
    gl::VertexArray array_;
    gl::Texture sum_;
    gl::Sampler sampler_;
    gl::Framebuffer volumeTarget_, darkTarget_;
    gl::Program volumes_, count_, dark_;
};

}  // namespace dapple::shadow
