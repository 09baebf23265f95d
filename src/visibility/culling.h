#pragma once

#include "gpuscene/item_table.h"
#include "visibility/occlusion_culler.h"

/// What a view, the camera's or the sun's, need not draw.
namespace dapple::visibility {

/// One frame of one view, as whoever renders it hands it to its culling.
struct ViewFrame {
    CullView view;
    double leastW = 0.5;        ///< clip w up to which nothing is known of a box
    const gl::Texture* depth = nullptr;  ///< 2D: what is drawn into; bound, with viewport and depth test
    bool depthClamp = false;    ///< whether drawing needs it
    /// Occlusion queries alone look at the rest. Mask: samples where it is < ½ do not count (R8 or R32F over the view's
    /// window, at most as fine as `depth`). Drawn: items that the view has already; none is drawn again.
    const gl::Texture* mask = nullptr;
    std::span<const uint32_t> drawn = {};
};

/// What one view draws of a scene, frame after frame.
class Culling {
public:
    virtual ~Culling() = default;
    /// Calls `submit` once or several times, with what it is to draw into what is bound.
    virtual void draw(const ViewFrame& frame, const gpuscene::Submit& submit) = 0;
    /// Items that the last draw() has drawn. May wait for the GPU.
    virtual std::vector<uint32_t> drawn() const = 0;
    /// Of its occlusion queries in the last draw(); empty where it asks none.
    virtual std::optional<Statistics> statistics() const { return std::nullopt; }
};

/// Lists on the CPU whatever is not outside a plane of the view: everything, where it has none. `keep`, if given, is asked of the
/// instances in every frame, by index.
class ListCulling final : public Culling {
public:
    ListCulling(const gpuscene::Items& items, bool castersOnly, std::function<bool(uint32_t instance)> keep = {});
    void draw(const ViewFrame& frame, const gpuscene::Submit& submit) override;
    std::vector<uint32_t> drawn() const override { return list_.items; }

private:
    const gpuscene::Items& items_;
    const gpuscene::Hierarchy& hierarchy_;
    std::function<bool(uint32_t)> keep_;
    gpuscene::DrawList list_;
};

/// For culling on the GPU: the groups that are not outside a plane of the view, the nearest first.
void pickGroups(const gpuscene::ItemTable& table, const CullView& view, gpuscene::ItemTable::Groups& groups);

}  // namespace dapple::visibility
