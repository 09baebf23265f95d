#pragma once

#include "gpuscene/instance_table.h"
#include "visibility/max_pyramid.h"

/// What a view, the camera's or the sun's, need not draw.
namespace dapple::visibility {

/// Where the look-ups of the visible receivers fall in a shadow map, and how far from the sun the farthest of them lies: a
/// pyramid of largest reference depths over a grid of the map's window, after the receiver masks of Mattausch et al. 2011
/// ("Efficient Online Visibility for Shadow Maps") with depth beside the mask. A caster that begins, seen from the sun,
/// behind all receivers of the cells that its box covers, or whose cells have none, cannot change a comparison.
///
/// Whoever resolves the map fills the finest level, because he alone knows what his look-ups read.
class ReceiverPyramid {
public:
    /// `mapSize`: texels along a side; `layers`: maps that have a pyramid each; `warped`: their matrices are not affine. Throws
    /// base::Error(failed): no memory.
    ReceiverPyramid(const gpuscene::GpuScene& scene, int mapSize, int layers, bool warped);

    void clear();
    /// R32UI array, keys of lib/receiver_key.glsl, to be filled with imageAtomicMax at level 0.
    const gl::Texture& texture() const { return pyramid_.texture(); }
    int cells() const { return pyramid_.cells(); }  ///< along a side of level 0, a power of two, no more than the map has texels
    /// Makes the coarser levels.
    void reduce() const { pyramid_.reduce(); }

    struct Map {
        int layer = 0;
        glm::dmat4 clipFromRelative{1};
        glm::dvec3 eye{0};    ///< metres from Scene::origin
        double leastW = 0.5;  ///< clip w up to which nothing is known of a box; 1/2 where there is no warp
    };
    /// Makes `list` the casters that the map needs, chosen on the GPU; nothing is read back.
    void choose(const Map& map, gpuscene::DrawList& list) const;

private:
    const gpuscene::InstanceTable& table_;
    int mapSize_;
    MaxPyramid pyramid_;
    gl::Program cull_;
};

}  // namespace dapple::visibility
