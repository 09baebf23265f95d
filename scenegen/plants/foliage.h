#pragma once

#include "scenegen/plants/skeleton.h"
#include "scenegen/scene.h"

#include <cstdint>
#include <span>

namespace dapple::scenegen {

enum class LeafMode {
    polygon,  ///< each leaf is two triangles folded along its midrib; opaque, open
    card,     ///< alpha-tested quads, each a cluster of leaves
};

/// Leaves (cards: clusters) that Weber and Penn's parameters give to a tree of which the stems `kept` are meshed.
size_t naturalLeaves(const Species& species, const Skeleton& skeleton, std::span<const uint32_t> kept, LeafMode mode);

/// `count` leaves or cards of two triangles each, each rooted on the axis of its twig or, where the mesh leaves the
/// twig out, of its parent. Fewer than natural are larger, more are smaller, so that the foliage keeps its area.
Mesh buildLeaves(const Species& species, const Skeleton& skeleton, std::span<const uint32_t> kept, LeafMode mode,
                 size_t count, uint64_t seed);

/// A drawn cluster of leaves or spray of needles with alpha, for the cards; its foot is in the middle of the lower edge.
/// Colours are relative: the material's albedo multiplies them.
base::Image8 drawCard(const Species& species, int size);

}  // namespace dapple::scenegen
