#pragma once

#include "frame/frame.h"
#include "shadow/registry.h"
#include "visibility/view.h"

#include <vector>

namespace dapple::shadow {

/// Masks of visible receivers in the windows of shadow maps (Mattausch, Bittner, Silvennoinen, Scherzer, Wimmer 2011,
/// "Efficient Online Visibility for Shadow Maps", section 1.3.2): occlusion queries of casters count only there. One mask a
/// map, at most 1024 cells a side, set wherever a look-up may read; how it is found is axis `mask`.
class ReceiverMask {
public:
    /// `map`: the array of maps, whose layers the rasterised masks are drawn into as well. `lookupDefines`: of lib/map_lookup.glsl.
    ReceiverMask(const frame::Frame& frame, const gpuscene::Items& items, const Settings& settings, const gl::Texture& map, const std::vector<std::string>& lookupDefines);

    /// Whether build() needs scatter() before.
    bool scatters() const { return kind_ == Kind::scatter; }
    /// Program of the scatter pass: the caller sets its lib/map_lookup.glsl, then calls scatter().
    const gl::Program& scatterProgram() const { return scatter_; }
    void scatter(measure::Ledger& tally);

    struct Receivers {
        const gpuscene::DrawList& casters;  ///< those in sight that cast
        const gpuscene::DrawList& others;   ///< those that only receive
        std::span<const uint32_t> all;      ///< items: both, and casters out of reach
    };
    /// Draws the casters in sight into a cleared map, and makes its mask unless scatter() has. The map's framebuffer is bound
    /// afterwards, with depth test and clamp on.
    void build(int layer, const gl::Framebuffer& mapTarget, const visibility::CullView& view, const Receivers& receivers, const gl::Program& depth,
               const gl::Program& depthAlpha, measure::Ledger& tally);

    const gl::Texture& mask(int layer) const { return masks_[size_t(layer)]; }
    /// Marks the mask in the stencil of the bound map, for a test that stops queries.
    void markStencil(int layer);

private:
    enum class Kind { scatter, box, geometry, fragment, fragmentOr };
    void drawMasked(const gpuscene::DrawList& list, const glm::dmat4& clip, measure::Ledger& tally);
    void drawBoxes(const visibility::CullView& view, std::span<const uint32_t> items, measure::Ledger& tally);

    const frame::Frame& frame_;
    const gpuscene::Items& items_;
    Kind kind_;
    int size_, reach_;  ///< of the map; texels that a look-up may read about its own
    gl::Texture cells_, texels_;      // array of masks; a mask at the map's resolution
    std::vector<gl::Texture> masks_;  // views of its layers
    std::vector<gl::Framebuffer> targets_;
    gl::Framebuffer boxTarget_;
    gl::VertexArray boxArray_;
    gl::Buffer boxes_;
    gl::Sampler nearest_;
    gl::Program scatter_, opaque_, alpha_, box_, coarse_, stencil_;
};

}  // namespace dapple::shadow
