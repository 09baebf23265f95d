#pragma once

#include "scenegen/plants/leaf.h"
#include "scenegen/plants/skeleton.h"

#include <cstdint>
#include <span>
#include <vector>

namespace dapple::scenegen {

/// Where the leaves of one twig grow: on the twig, or, where the mesh leaves it out, on its parent where it began.
struct LeafSite {
    uint32_t twig;            ///< index of the stem
    const Stem* stem;         ///< that they grow on
    const Stem* missingTwig;  ///< whose direction the leaves keep; null when `stem` is the twig
    double begin, end;        ///< offsets on `stem`, metres
    double leaves;            ///< (cards: clusters) that the parameters ask for
    double size;              ///< of its leaves, relative
};

/// Sites that Weber and Penn's parameters give to a tree of which the stems `kept` are meshed; they point into
/// `skeleton`. `floating`: leaves stay where an unmeshed twig would be, which nobody sees from afar.
std::vector<LeafSite> leafSites(const Species& species, const Skeleton& skeleton, std::span<const uint32_t> kept, LeafMode mode, bool floating);

size_t naturalLeaves(std::span<const LeafSite> sites);

/// `count` leaves or cards, each rooted on the axis of its site's stem. Fewer than natural are larger, more are smaller,
/// so that the foliage keeps its area. Polygon and solid leaves have the same places and outlines. From `lod` 1 on a
/// leaf stands for several: it grows to both sides of its root, so that the crown keeps its outline, and is a diamond.
Mesh buildLeaves(const Species& species, std::span<const LeafSite> sites, LeafMode mode, size_t count, int lod, uint64_t seed);

/// Outline of the leaves at a level of detail.
inline LeafShape leafShape(const Species& species, int lod) { return lod == 0 ? species.leaves.shape : LeafShape::diamond; }

/// A drawn cluster of leaves, spray of needles or tuft of blades with alpha, for the cards; its foot is in the middle of the lower edge.
/// Colours are relative: the material's albedo multiplies them.
base::Image8 drawCard(const Species& species, int size);

}  // namespace dapple::scenegen
