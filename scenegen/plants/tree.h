#pragma once

#include "scenegen/plants/foliage.h"
#include "scenegen/plants/species.h"
#include "scenegen/plants/wind.h"

#include <optional>

namespace dapple::scenegen {

struct TreeOptions {
    uint64_t seed = 1;      ///< the individual
    /// Budget; 0: what the species' parameters give. It chooses stems and leaves, and solid leaves are those that
    /// the same budget gives as polygons: with them the tree has more triangles, but the same shape.
    size_t triangles = 0;
    LeafMode leaves = LeafMode::polygon;
    /// 0, 1, 2: how far away the tree will be seen. The skeleton is the same; from 1 on leaves may grow large and stay
    /// where their twig would be if it is not meshed. Species::triangles has the budget that goes with it.
    int lod = 0;
    std::optional<Wind> wind = std::nullopt;
};

/// Foot at the origin, z up, metres. Meshes carry no material yet.
struct Tree {
    Mesh bark;    ///< closed, oriented tubes, one per stem
    Mesh leaves;  ///< open, but for LeafMode::solid
};

/// Most triangles of a tree of `triangles` that its stems may use at a level of detail; 0 for 0, which is no limit.
size_t barkBudget(const Species& species, size_t triangles, int lod);

/// Grows one individual. With a budget the tree has that many triangles, less what is too little for one leaf more.
/// Throws UsageError when the budget is below what trunk and a few leaves need.
Tree growTree(const Species& species, const TreeOptions& options);

}  // namespace dapple::scenegen
