#pragma once

#include <glm/glm.hpp>

#include <string>
#include <vector>

namespace dapple::scenegen::city {

/// How a file's coordinates become metres.
enum class Crs {
    degrees,   ///< longitude and latitude
    mercator,  ///< Web Mercator: metres only at the equator, 1.5 times too many at 48 degrees
    metres,    ///< of a plane
};

/// The system that a GeoJSON file names. No name: degrees, or metres when the user says `projected`. UTM zones count as
/// metres of a plane (0.1 % off at most). Throws UsageError with `name` for systems that are not read, unless
/// `projected` says that their unit is the metre.
Crs crsOf(const std::string& crs, bool projected, const std::string& name);

/// Puts points given as `crs` on a plane, in metres about the middle of all: equirectangular from degrees (0.1 % off at
/// 20 km), also across the 180th meridian. Throws UsageError: no longitudes and latitudes, more than 100 km.
void projectToPlane(const std::vector<glm::dvec2*>& points, Crs crs, const std::string& name);

}  // namespace dapple::scenegen::city
