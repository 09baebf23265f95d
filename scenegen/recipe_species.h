#pragma once

#include "base/config.h"
#include "scenegen/placement/forest.h"
#include "scenegen/plants/tree.h"

#include <optional>

namespace dapple::scenegen {

/// A table [[species]] of a recipe.
struct SpeciesEntry {
    Species species;
    int individuals = 1;
    size_t triangles = 0;
    LeafMode leaves = LeafMode::polygon;
    int lod = 0;
    double keep = 1;
    float transmittance = 0;
    Stand stand;  ///< its individuals come when they are grown
    std::optional<glm::dvec2> position;  ///< of its one tree, which is not scattered
};

/// Throws UsageError with file, line and key, also when its individuals would not fit into memory.
SpeciesEntry readSpeciesEntry(base::ConfigTable& t);

}  // namespace dapple::scenegen
