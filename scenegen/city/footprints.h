#pragma once

#include "scenegen/scene.h"

#include <filesystem>
#include <string_view>
#include <vector>

/// Real buildings: GeoJSON footprints with heights, as OpenStreetMap, cities' open data and vector tiles give them.
namespace dapple::scenegen::city {

/// Outline of one building and its courtyards: counter-clockwise, then clockwise; simple, apart, plan metres.
struct Footprint {
    std::vector<std::vector<glm::dvec2>> rings;
    double height = 0;  ///< metres, above 0
};

struct Footprints {
    std::vector<Footprint> buildings;
    size_t withoutHeight = 0;  ///< given the usual height
    size_t refused = 0;        ///< outlines that cross or touch themselves, smaller than a square metre, or given twice
};

inline constexpr double kStorey = 3.2;       ///< metres per level where a file gives only these
inline constexpr double kUsualHeight = 6.0;  ///< of a building of which the file does not say

/// Polygons and MultiPolygons of a FeatureCollection. Heights are properties `height` or `render_height` (metres, a
/// number or a text that begins with one), else `building:levels` or `levels` × kStorey. Coordinates are degrees of
/// longitude and latitude, laid on a plane about the middle (equirectangular: 0.1 % off at 20 km), or metres when
/// `projected`. The middle becomes the origin. Throws UsageError with the name and the reason: no JSON, no
/// FeatureCollection, no building, a coordinate that is no number or no longitude.
Footprints parseFootprints(std::string_view json, const std::string& name, bool projected);

/// A closed prism of a footprint, from half a metre below the ground; its walls keep `joint` metres to the outline, so
/// that no two neighbours share a corner. Empty if the outline is too thin to be triangulated.
Mesh footprintPrism(const Footprint& footprint, double joint);

/// Ground, buildings by cells of 250 m, and views: walk0 … among the most built, and `above`.
void addFootprints(Scene& scene, const Footprints& footprints, int views, double fovY, uint64_t seed);

}  // namespace dapple::scenegen::city
