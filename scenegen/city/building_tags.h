#pragma once

#include "scenegen/import/notes.h"

#include <nlohmann/json_fwd.hpp>

#include <optional>
#include <string>
#include <string_view>

namespace dapple::scenegen::city {

inline constexpr double kStorey = 3.2;       ///< metres per level where a file gives only these
inline constexpr double kUsualHeight = 6.0;  ///< of a building of which the file does not say

/// What a feature's properties say of a building, in the words of OpenStreetMap, OpenMapTiles or Overture.
struct BuildingTags {
    bool stands = true;    ///< false: underground, or said to be no building
    bool isPart = false;   ///< building:part: stands in place of the outline that it lies in
    double base = 0;       ///< metres above the ground
    double height = 0;     ///< metres above the ground, above `base`
    bool knowsHeight = false;  ///< else `height` is the usual one above `base`
};

/// Metres of a text such as "20", " 20.5 m", "20,5", "~66 ft", "66'" or "65'7\""; nothing for any other text.
std::optional<double> parseLength(std::string_view text);

/// Heights are `height`, `render_height` or `building:height`, else `building:levels`, `levels` or `num_floors` times
/// kStorey; bases likewise with `min`. What is there and cannot be used is counted in `notes`.
BuildingTags readBuildingTags(const nlohmann::json& properties, Notes& notes);

}  // namespace dapple::scenegen::city
