#include "scenegen/city/footprints.h"

#include "base/detmath.h"
#include "base/error.h"
#include "scenegen/city/triangulate.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>
#include <tuple>

namespace dapple::scenegen::city {
namespace {
using Json = nlohmann::json;

constexpr double kMetresPerDegree = 111'319.4908;  // of the equator of WGS 84

[[noreturn]] void fail(const std::string& name, const std::string& why) { throw base::UsageError(name + ": " + why); }

/// A number, or the one that a text begins with ("12.5 m"); 0 if neither.
double leadingNumber(const Json& value) {
    if (value.is_number()) return value.get<double>();
    double number = 0;
    if (value.is_string()) {
        const std::string& text = value.get_ref<const std::string&>();
        std::from_chars(text.data(), text.data() + text.size(), number);
    }
    return number;
}

/// Metres; 0 when nothing says it, or nothing that a building could have.
double heightOf(const Json& feature) {
    const auto properties = feature.find("properties");
    if (properties == feature.end() || !properties->is_object()) return 0;
    for (const auto& [key, metres] : {std::pair("height", 1.0), {"render_height", 1.0}, {"building:levels", kStorey}, {"levels", kStorey}})
        if (const auto at = properties->find(key); at != properties->end())
            if (const double h = leadingNumber(*at) * metres; h > 0 && h < 2000) return h;
    return 0;
}

Ring readRing(const Json& json, const std::string& name, size_t feature) {
    if (!json.is_array()) fail(name, fmt::format("feature {}: a ring is not an array", feature));
    Ring ring;
    for (const Json& p : json) {
        if (!p.is_array() || p.size() < 2 || !p[0].is_number() || !p[1].is_number()) fail(name, fmt::format("feature {}: a coordinate is not a pair of numbers", feature));
        ring.emplace_back(p[0].get<double>(), p[1].get<double>());
        if (!(std::abs(ring.back().x) < 1e9 && std::abs(ring.back().y) < 1e9)) fail(name, fmt::format("feature {}: a coordinate is beyond reason", feature));
    }
    return ring;
}

/// Without repeated corners and those within a millimetre of the line between their neighbours.
Ring cleaned(const Ring& ring) {
    Ring out;
    for (const glm::dvec2& p : ring)
        if (out.empty() || glm::distance(out.back(), p) > 0.02) out.push_back(p);
    while (out.size() > 1 && glm::distance(out.back(), out.front()) <= 0.02) out.pop_back();
    for (size_t i = 0; i < out.size() && out.size() > 3;) {
        const glm::dvec2 a = out[(i + out.size() - 1) % out.size()], c = out[(i + 1) % out.size()], d = c - a;
        const double length = std::sqrt(glm::dot(d, d));
        if (length < 1e-9 || std::abs(d.x * (out[i].y - a.y) - d.y * (out[i].x - a.x)) > 1e-3 * length) ++i;
        else out.erase(out.begin() + std::ptrdiff_t(i));
    }
    return out;
}

/// Rings turned the right way; empty if this is no building.
std::vector<Ring> cleaned(const std::vector<Ring>& rings) {
    std::vector<Ring> out;
    for (const Ring& given : rings) {
        Ring ring = cleaned(given);
        const bool outer = out.empty();
        if (ring.size() < 3 || std::abs(twiceArea(ring)) < 2 || !isSimple(ring)) {
            if (outer) return {};
            continue;
        }
        if ((twiceArea(ring) > 0) != outer) std::reverse(ring.begin(), ring.end());
        const auto apart = [&](const Ring& other) { return areApart(ring, other); };
        if (!std::all_of(out.begin(), out.end(), apart)) continue;
        // A courtyard lies within the outline and not within another courtyard.
        const auto within = [&](const Ring& other) { return contains(other, ring[0]); };
        if (!outer && (!within(out[0]) || std::any_of(out.begin() + 1, out.end(), within))) continue;
        out.push_back(std::move(ring));
    }
    return out;
}

}  // namespace

Footprints parseFootprints(std::string_view text, const std::string& name, bool projected) {
    const Json json = Json::parse(text, nullptr, false);
    if (json.is_discarded()) fail(name, "not valid JSON");
    const auto says = [](const Json& object, const char* type) { return object.contains("type") && object["type"] == type; };
    if (!json.is_object() || !says(json, "FeatureCollection") || !json.contains("features") || !json["features"].is_array())
        fail(name, "not a GeoJSON FeatureCollection");
    struct Raw {
        std::vector<Ring> rings;
        double height;
    };
    std::vector<Raw> raw;
    size_t number = 0;
    for (const Json& feature : json["features"]) {
        ++number;
        if (!feature.is_object() || !feature.contains("geometry") || !feature["geometry"].is_object()) continue;
        const Json& geometry = feature["geometry"];
        const bool single = says(geometry, "Polygon");
        if (!single && !says(geometry, "MultiPolygon")) continue;
        if (!geometry.contains("coordinates") || !geometry["coordinates"].is_array()) fail(name, fmt::format("feature {}: a polygon without coordinates", number));
        const Json polygons = single ? Json::array({geometry["coordinates"]}) : geometry["coordinates"];
        for (const Json& polygon : polygons) {
            if (!polygon.is_array()) fail(name, fmt::format("feature {}: a polygon is not an array of rings", number));
            Raw r{{}, heightOf(feature)};
            for (const Json& ring : polygon) r.rings.push_back(readRing(ring, name, number));
            if (!r.rings.empty()) raw.push_back(std::move(r));
        }
    }
    glm::dvec2 lo(1e300), hi(-1e300);
    for (const Raw& r : raw)
        for (const glm::dvec2& p : r.rings[0]) lo = glm::min(lo, p), hi = glm::max(hi, p);
    if (raw.empty() || lo.x > hi.x) fail(name, "has no building: no polygon in it");
    if (!projected && (std::max(std::abs(lo.x), std::abs(hi.x)) > 180 || std::max(std::abs(lo.y), std::abs(hi.y)) > 90))
        fail(name, "its coordinates are no longitudes and latitudes; say projected = true if they are metres");
    const glm::dvec2 middle = 0.5 * (lo + hi);
    const glm::dvec2 unit = projected ? glm::dvec2(1) : kMetresPerDegree * glm::dvec2(base::det::cos(middle.y * base::det::kDegree), 1);
    const glm::dvec2 size = (hi - lo) * unit;
    if (std::max(size.x, size.y) > 100'000) fail(name, fmt::format("{:.0f} km from end to end; a city of at most 100 km was expected", std::max(size.x, size.y) / 1000));

    Footprints out;
    std::set<std::tuple<int64_t, int64_t, int64_t>> seen;
    for (Raw& r : raw) {
        for (Ring& ring : r.rings)
            for (glm::dvec2& p : ring) p = (p - middle) * unit;
        std::vector<Ring> rings = cleaned(r.rings);
        glm::dvec2 sum(0);
        if (!rings.empty())
            for (const glm::dvec2& p : rings[0]) sum += p / double(rings[0].size());
        const auto key = [](double x) { return int64_t(std::floor(x * 10)); };
        if (rings.empty() || !seen.insert({key(sum.x), key(sum.y), rings.empty() ? 0 : key(twiceArea(rings[0]))}).second) {
            ++out.refused;
            continue;
        }
        out.withoutHeight += r.height == 0;
        out.buildings.push_back({std::move(rings), r.height > 0 ? r.height : kUsualHeight});
    }
    if (out.buildings.empty()) fail(name, "has no building: every polygon crosses itself or is smaller than 1 m²");
    return out;
}

}  // namespace dapple::scenegen::city
