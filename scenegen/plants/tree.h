#pragma once

#include "scenegen/plants/foliage.h"
#include "scenegen/plants/species.h"

namespace dapple::scenegen {

struct TreeOptions {
    uint64_t seed = 1;      ///< the individual
    size_t triangles = 0;   ///< budget; 0: what the species' parameters give
    LeafMode leaves = LeafMode::polygon;
};

/// Foot at the origin, z up, metres. Meshes carry no material yet.
struct Tree {
    Mesh bark;    ///< closed, oriented tubes, one per stem
    Mesh leaves;  ///< open
};

/// Grows one individual. With a budget the tree has exactly that many triangles, less one if it is odd.
/// Throws UsageError when the budget is below what trunk and a few leaves need.
Tree growTree(const Species& species, const TreeOptions& options);

}  // namespace dapple::scenegen
