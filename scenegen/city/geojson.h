#pragma once

#include "scenegen/city/rings.h"
#include "scenegen/import/notes.h"

#include <nlohmann/json_fwd.hpp>

#include <functional>
#include <string>
#include <string_view>

namespace dapple::scenegen::city {

/// Given for each polygon: its rings in the file's own coordinates, as they stand there, and the properties of its
/// feature (an empty object for a bare geometry).
using PolygonSink = std::function<void(std::vector<Ring> rings, const nlohmann::json& properties)>;

/// Reads GeoJSON (RFC 7946): a FeatureCollection, Feature or geometry, or a sequence of them (one a line, or RFC 8142).
/// What is no polygon is counted in `notes`. Returns the name of the coordinate reference system, as the older
/// standard's member `crs` gives it; empty: none. Throws UsageError with `name` and the reason: not JSON, not GeoJSON,
/// nested deeper than 64, a coordinate that is no number.
std::string readGeoJson(std::string_view text, const std::string& name, const PolygonSink& sink, Notes& notes);

}  // namespace dapple::scenegen::city
