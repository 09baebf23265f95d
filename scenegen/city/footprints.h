#pragma once

#include "scenegen/city/building_tags.h"
#include "scenegen/scene.h"

#include <string>
#include <string_view>
#include <vector>

/// Real buildings: GeoJSON footprints with heights, as OpenStreetMap, cities' open data and vector tiles give them.
namespace dapple::scenegen::city {

/// Outline of one building and its courtyards: counter-clockwise, then clockwise, plan metres. Rings do not cross, but
/// may touch themselves at a point.
struct Footprint {
    std::vector<std::vector<glm::dvec2>> rings;
    double height = 0;  ///< metres above the ground, above `base`
    double base = 0;    ///< metres; 0: on the ground
};

struct Footprints {
    std::vector<Footprint> buildings;
    size_t withoutHeight = 0;  ///< given the usual height
    size_t refused = 0;        ///< outlines that cross themselves, smaller than a square metre, or given twice
    Notes notes;               ///< what is not built as the file says, each with its reason
};

/// Buildings of GeoJSON (city/geojson.h) with what their properties say (city/building_tags.h), on a plane about the
/// middle (city/projection.h). `projected`: coordinates of a file that names no system are metres. Outlines in which a
/// building:part lies are not built, as OpenStreetMap's Simple 3D Buildings has it.
/// Throws UsageError with the name and the reason: no GeoJSON, no building, what the budget of a file does not allow.
Footprints parseFootprints(std::string_view json, const std::string& name, bool projected);

/// A closed prism of a footprint, from its base, or half a metre below the ground; its walls keep `joint` metres to the
/// outline, so that no two neighbours share a corner. Empty if the outline is too thin for that.
Mesh footprintPrism(const Footprint& footprint, double joint);

/// Ground, buildings by cells of 250 m, and views: walk0 … among the most built, and `above`. What is not built as the
/// file says goes to the scene's notes.
void addFootprints(Scene& scene, const Footprints& footprints, int views, double fovY, uint64_t seed);

}  // namespace dapple::scenegen::city
