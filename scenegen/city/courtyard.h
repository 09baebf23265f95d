#pragma once

#include "base/config.h"
#include "scenegen/scene.h"

namespace dapple::scenegen {

/// What a recipe's [courtyard] says: a court of two storeys of arcades under the open sky.
struct Courtyard {
    int bays = 9;         ///< along the court (x), ≥ 2, of 4 m each
    int across = 4;       ///< ≥ 2
    size_t plants = 800;  ///< triangles of each plant and tree, counted with polygons for leaves; 0: none
    double fovY = 60;     ///< degrees
};

/// Reads the table: bays, across, plants, fovY. `scale` multiplies the bays: the recipe's, 0.01 … 64. Throws UsageError
/// with file, line and key.
Courtyard readCourtyard(base::ConfigTable& table, double scale);

/// Adds the court about the scene's origin, and the views of a flight through it: fly0 (on its ground), fly1 (along the
/// arcade), fly2 (out of it, through an arch), fly3 (along the gallery), fly4 (over the court), fly5 (from the roof's
/// edge), and `above`. Every casting prototype is closed.
void addCourtyard(Scene& scene, const Courtyard& courtyard, uint64_t seed);

}  // namespace dapple::scenegen
