#pragma once

#include "gpuscene/item_table.h"
#include "base/image.h"
#include "visibility/culling.h"
#include "visibility/max_pyramid.h"

namespace dapple::visibility {

/// Where the look-ups of the visible receivers fall in a shadow map, and how far from the sun the farthest of them lies: a
/// pyramid of largest reference depths over a grid of the map's window, after the receiver masks of Mattausch et al. 2011
/// ("Efficient Online Visibility for Shadow Maps") with depth beside the mask. A caster that begins, seen from the sun,
/// behind all receivers of the cells that its boxes cover, or whose cells have none, cannot change a comparison.
///
/// Whoever resolves the map marks the cells, because he alone knows what his look-ups read: for each look-up the one cell in which
/// its first texel lies, that with the least coordinates, in the finest levels. What it costs depends on the look-ups and not on
/// the map's size: cells are not cleared but stamped with the frame.
class ReceiverPyramid {
public:
    static constexpr int kDepthBits = 20;  ///< of a key, below the frame's stamp: lib/receiver_key.glsl

    /// `mapSize`: texels along a side; `layers`: maps that have a pyramid each; `beyond`: texels, along both axes, that a look-up
    /// reads after its first one. Throws base::Error(failed): no memory.
    ReceiverPyramid(int mapSize, int layers, int beyond);

    /// Forgets all receivers.
    void clear();
    /// Binds the levels that are to be marked to image units 0, 1 and 2; sets what lib/receiver_key.glsl has.
    void setMarking(const gl::Program& program) const;
    /// R32UI array, keys of lib/receiver_key.glsl.
    const gl::Texture& texture() const { return pyramid_.texture(); }
    int cells() const { return pyramid_.width(); }  ///< along a side of level 0, a power of two, no more than the map has texels
    int markedLevels() const { return markedLevels_; }  ///< 1 to 3; reduce() makes the others
    int stamp() const { return stamp_; }                ///< of this frame
    /// Which cells of `layer` are marked: 1 or 0, rows from the top. Waits for the GPU.
    base::ImageF mask(int layer) const;
    /// Makes the coarser levels.
    void reduce() const { pyramid_.reduce(markedLevels_ - 1); }

    /// Looks at what receivers `layer` has, on the GPU; nothing is read back.
    void choose(const gpuscene::ItemTable& table, const gpuscene::ItemTable::Groups& groups, int layer, const ViewFrame& frame, gpuscene::DrawList& list) const;

private:
    int mapSize_, beyond_, markedLevels_ = 1, stamp_ = 1;
    MaxPyramid pyramid_;
    gl::Program groups_, items_;
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
