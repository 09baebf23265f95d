#include "scenegen/city/projection.h"

#include "base/detmath.h"
#include "base/error.h"
#include "scenegen/import/notes.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace dapple::scenegen::city {
namespace {

constexpr double kMetresPerDegree = 111'319.4908;  // of the equator of WGS 84
constexpr double kLargest = 100'000;               // metres

/// Latitude in radians of Web Mercator's y over the sphere's radius: sin(latitude) = tanh(y), the same bits everywhere.
double latitude(double y) {
    const double e = base::det::exp2(y / 0.69314718055994530942), sine = (e - 1 / e) / (e + 1 / e);
    double angle = 0.5 * base::det::kPi - base::det::acos(sine);
    for (int i = 0; i < 2; ++i) {  // Newton: acos is good to 3e-8
        const auto [s, c] = base::det::sinCos(angle);
        angle += (sine - s) / c;
    }
    return angle;
}

bool isAmong(int code, int from, int to) { return code >= from && code <= to; }

}  // namespace

Crs crsOf(const std::string& crs, bool projected, const std::string& name) {
    if (crs.empty()) return projected ? Crs::metres : Crs::degrees;
    if (crs.ends_with("CRS84") || crs.ends_with("CRS83") || crs.ends_with("WGS84")) return Crs::degrees;
    // "EPSG:3857", "urn:ogc:def:crs:EPSG:6.9:3857", "http://www.opengis.net/def/crs/EPSG/0/3857"
    const size_t at = crs.find_last_of(":/") + 1;
    int code = 0;
    const auto [end, error] = std::from_chars(crs.data() + at, crs.data() + crs.size(), code);
    if (crs.find("EPSG") == crs.npos || error != std::errc() || end != crs.data() + crs.size()) code = 0;
    for (const int degrees : {4326, 4979, 4258, 4269})  // WGS 84, ETRS89, NAD83: within a metre or two of one another
        if (code == degrees) return Crs::degrees;
    for (const int mercator : {3857, 900913, 3785, 102100, 102113})
        if (code == mercator) return Crs::mercator;
    const bool isUtm = isAmong(code, 32601, 32660) || isAmong(code, 32701, 32760) || isAmong(code, 25828, 25838) ||
                       isAmong(code, 26901, 26923);
    if (isUtm || projected) return Crs::metres;
    throw base::UsageError(
        fmt::format("{}: its coordinate reference system, {}, is not read; convert the file to longitude and latitude, "
                    "or say projected = true if its unit is the metre", name, printable(crs)));
}

void projectToPlane(const std::vector<glm::dvec2*>& points, Crs crs, const std::string& name) {
    if (points.empty()) return;
    if (crs == Crs::mercator)
        for (glm::dvec2* p : points) {
            if (std::max(std::abs(p->x), std::abs(p->y)) > 4.1e7)
                throw base::UsageError(name + ": its coordinates lie beyond Web Mercator's map, which its crs names");
            *p = {p->x / kMetresPerDegree, latitude(p->y * base::det::kDegree / kMetresPerDegree) / base::det::kDegree};
        }
    if (crs != Crs::metres)
        for (glm::dvec2* p : points) {
            if (!(std::abs(p->x) <= 360 && std::abs(p->y) <= 90))
                throw base::UsageError(name + ": its coordinates are no longitudes and latitudes; "
                                              "say projected = true if they are metres");
            // Within half a turn of the first: 180 and -180 degrees are one place.
            p->x -= 360 * std::round((p->x - points[0]->x) / 360);
        }
    glm::dvec2 lo(1e300), hi(-1e300);
    for (const glm::dvec2* p : points) lo = glm::min(lo, *p), hi = glm::max(hi, *p);
    const glm::dvec2 middle = 0.5 * (lo + hi);
    glm::dvec2 unit(1);
    if (crs != Crs::metres) unit = kMetresPerDegree * glm::dvec2(base::det::cos(middle.y * base::det::kDegree), 1);
    const double size = std::max((hi.x - lo.x) * unit.x, (hi.y - lo.y) * unit.y);
    if (size > kLargest)
        throw base::UsageError(fmt::format("{}: {:.0f} km from end to end; a city of at most {:.0f} km was expected",
                                           name, size / 1000, kLargest / 1000));
    for (glm::dvec2* p : points) *p = (*p - middle) * unit;
}

}  // namespace dapple::scenegen::city
