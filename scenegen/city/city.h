#pragma once

#include "base/config.h"
#include "scenegen/city/plan.h"
#include "scenegen/scene.h"

#include <filesystem>

namespace dapple::scenegen {

/// What a recipe's [city] says.
struct City {
    city::Style style = city::Style::vienna;
    double scale = 1;             ///< of the area: 1 is the size that the style is known for
    size_t treeTriangles = 2000;  ///< per street tree; 0: no trees
    double traffic = 0;           ///< moving cars per kilometre of lane
    double nearDetail = 0;        ///< metres from a view beyond which houses and street trees are plainer; 0: nowhere
    bool night = false;           ///< street lamps shine, and the sun stands at least 12° below the horizon
    int views = 6;                ///< walk0 …: on streets, 1.7 m above them
    double fovY = 60;             ///< degrees
    std::filesystem::path footprints;  ///< GeoJSON file of real buildings in place of a style; empty: none
    bool projected = false;       ///< its coordinates are metres, not degrees
};

/// Reads the table: style = "vienna" | "manhattan", trees (triangles each), traffic, nearDetail, night, views, fovY; or footprints
/// (see ConfigTable::path), projected, views, fovY. `scale`: the recipe's, 1/1024 … 64. Throws UsageError with file, line and key.
City readCity(base::ConfigTable& table, double scale);

/// Adds ground, streets, buildings and furniture about the scene's origin, and the views: walk0 … and above.
/// Throws UsageError with the name and the reason when footprints cannot be read.
/// vienna at scale 1: 0.9 km², perimeter blocks with courtyards; manhattan: 7.7 km², towers on a grid.
void addCity(Scene& scene, const City& city, uint64_t seed);

}  // namespace dapple::scenegen
