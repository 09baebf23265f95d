#pragma once

#include "gpuscene/item_table.h"
#include "visibility/culling.h"
#include "visibility/max_pyramid.h"

namespace dapple::visibility {

/// Two-phase occlusion culling on the GPU against a hierarchy of depths (Greene, Kass, Miller 1993, "Hierarchical Z-Buffer
/// Visibility"; two phases after Aaltonen and Haar 2015, "GPU-Driven Rendering Pipelines"): what was visible in the last frame
/// is drawn, then what the depth so drawn does not hide. Indirect draws, nothing is read back, nothing waits.
/// The first frame, and one after a cut, draws little in its first phase, and is right all the same.
class HizCulling final : public Culling {
public:
    struct Options {
        glm::ivec2 pixels{0};      ///< of the view: width, height
        bool castersOnly = false;  ///< leave out what casts no shadow
        bool reversed = false;     ///< depth 1 is near, and tested with GL_GREATER
    };
    HizCulling(const gpuscene::Items& items, const Options& options);

    void draw(const ViewFrame& frame, const gpuscene::Submit& submit) override;
    std::vector<uint32_t> drawn() const override;

private:
    void setUp(const gl::Program& program, const ViewFrame& frame) const;

    const gpuscene::ItemTable& table_;
    bool reversed_;
    int cellPixels_;  // a side of a cell of the pyramid's finest level; 2: the image's pixels are cells, too, one level before
    MaxPyramid farthest_;
    gl::Buffer histories_;  // of hiz_cull.comp, by place in the table
    int frame_ = 0;
    gl::Program first_, secondGroups_, second_, cells_;
    gl::Sampler nearest_;
    gpuscene::ItemTable::Groups groups_;
    gpuscene::DrawList lists_[2];  // by phase
};

}  // namespace dapple::visibility
