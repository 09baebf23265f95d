#pragma once

#include "gpuscene/item_table.h"
#include "base/image.h"
#include "visibility/culling.h"
#include "visibility/max_pyramid.h"

namespace dapple::visibility {

/// Where the look-ups of the visible receivers fall in a shadow map, and how far from the sun the farthest of them lies: a
/// pyramid of largest reference depths over a grid of the map's window, after the receiver masks of Mattausch et al. 2011
/// ("Efficient Online Visibility for Shadow Maps") with depth beside the mask. A caster that begins, seen from the sun,
/// behind all receivers of the cells that its box covers, or whose cells have none, cannot change a comparison.
///
/// Whoever resolves the map fills the finest level, because he alone knows what his look-ups read.
class ReceiverPyramid {
public:
    /// `mapSize`: texels along a side; `layers`: maps that have a pyramid each. Throws base::Error(failed): no memory.
    ReceiverPyramid(int mapSize, int layers);

    void clear();
    /// R32UI array, keys of lib/receiver_key.glsl, to be filled with imageAtomicMax at level 0.
    const gl::Texture& texture() const { return pyramid_.texture(); }
    int cells() const { return cells_; }  ///< along a side of level 0, a power of two, no more than the map has texels
    /// Which cells of `layer` hold receivers: 1 or 0, rows from the top. Waits for the GPU.
    base::ImageF mask(int layer) const;
    /// Makes the coarser levels.
    void reduce() const { pyramid_.reduce(); }

    /// Looks at what receivers `layer` has, on the GPU; nothing is read back.
    void choose(const gpuscene::ItemTable& table, const gpuscene::ItemTable::Groups& groups, int layer, const ViewFrame& frame, gpuscene::DrawList& list) const;

private:
    int mapSize_, cells_;
    MaxPyramid pyramid_;
    gl::Program cull_;
};

/// The casters that one map needs of those that are not outside a plane of the view.
class PyramidCulling final : public Culling {
public:
    /// The pyramid must outlive it, and be filled before each draw().
    PyramidCulling(const gpuscene::Items& items, const ReceiverPyramid& pyramid, int layer) : table_(items.table(true)), pyramid_(pyramid), layer_(layer) {}

    void draw(const ViewFrame& frame, const gpuscene::Submit& submit) override;
    std::vector<uint32_t> drawn() const override;

private:
    const gpuscene::ItemTable& table_;
    const ReceiverPyramid& pyramid_;
    int layer_;
    gpuscene::ItemTable::Groups groups_;
    gpuscene::DrawList list_;
};

}  // namespace dapple::visibility
