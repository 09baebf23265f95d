#pragma once

#include "base/config.h"
#include "scenegen/import/notes.h"
#include "scenegen/terrain/height_field.h"

namespace dapple::scenegen {

struct Terrain {
    HeightField field;
    int tiles = 4;         ///< per side, each a closed body of its own
    double detail = 0;     ///< metres: tiles farther from every view are coarser, by 2 per doubling; 0 = full detail
    double skirt = 2;      ///< metres that a tile's floor lies below its lowest point
    Notes notes;           ///< what is not as the file has it
    glm::vec3 albedo{0.16f, 0.15f, 0.08f};
    /// Side of the largest square about the origin, metres.
    double size() const { return field.spacing * (std::min(field.columns, field.rows) - 1); }
};

/// The table [terrain] of a recipe. `area` multiplies the ground that it covers. Throws UsageError with file, line and key.
Terrain readTerrain(base::ConfigTable& table, uint64_t seed, double area);

/// Adds the tiles, once the scene has its views.
void addTerrain(Scene& scene, const Terrain& terrain);

}  // namespace dapple::scenegen
